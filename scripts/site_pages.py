"""A hook of mkdocs: adds what is not below docs/ (the changelog, how to contribute), and the look of code.

Code is coloured when the site is made, so its pages need no network. Each block has a button that copies it.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File
from pygments.formatters import HtmlFormatter

ROOT = Path(__file__).resolve().parents[1]
PAGES = {"changelog.md": "CHANGELOG.md", "contributing.md": "CONTRIBUTING.md", "security.md": "SECURITY.md"}
"Pages of the site, and the files that they are made of."
COPY = """
document.addEventListener("DOMContentLoaded", () => {
  for (const code of document.querySelectorAll(".highlight")) {
    const button = document.createElement("button");
    button.className = "copy";
    button.textContent = "copy";
    button.onclick = () => navigator.clipboard.writeText(code.querySelector("code").innerText.trimEnd())
      .then(() => { button.textContent = "copied"; });
    code.append(button);
  }
});
"""
LOOK = """
.highlight { position: relative }
.highlight .copy { position: absolute; top: .3em; right: .3em; font-size: .75em; opacity: .5 }
.highlight:hover .copy, .highlight .copy:focus { opacity: 1 }
"""


def on_files(files: Any, config: Any) -> Any:
    """Add the pages, and the files of the code's look."""
    for page, source in PAGES.items():
        text = _links_from_docs((ROOT / source).read_text("utf-8"))
        files.append(File.generated(config, page, content=text))
    style = (
        _colours("default", ".highlight") + _colours("github-dark", "[data-bs-theme=dark] .highlight") + LOOK
    )
    files.append(File.generated(config, "code.css", content=style))
    files.append(File.generated(config, "code.js", content=COPY))
    return files


def _colours(style: str, selector: str) -> str:
    return str(HtmlFormatter(style=style).get_style_defs(selector)) + "\n"


def _links_from_docs(text: str) -> str:
    """Make links to files of docs/ relative to it, and those to each other links to the pages."""
    for page, source in PAGES.items():
        text = text.replace(f"]({source}", f"]({page}")
    text = re.sub(r"\]\(docs/", "](", text)
    # What else lies in the repository has no page.
    return re.sub(r"\[([^]]+)\]\((?!https?:|#|[\w./-]+\.md)[^)]+\)", r"\1", text)
