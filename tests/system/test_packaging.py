"""The source distribution is complete, and its installation needs no checkout."""

import fnmatch
import json
import os
import re
import shlex
import shutil
import subprocess
import sysconfig
import venv
from pathlib import Path

import pytest

import isolation
from grabbergui.cli import command_line
from patience import PROGRAM

ROOT = Path(__file__).parents[2]
BY_ITSELF = {"grabbergui", "pyproject.toml", "setup.py", "LICENSE", "COPYING.exception", "MANIFEST.in"}
"""Files that setuptools adds by itself."""


def tracked():
    """Return the paths of the repository's files, those not committed yet included."""
    try:
        listed = subprocess.run(
            ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("this is no git repository")
    return [path for path in listed.splitlines() if (ROOT / path).is_file()]


def test_every_file_of_the_repository_is_in_the_source_distribution():
    patterns = BY_ITSELF.copy()
    for line in (ROOT / "MANIFEST.in").read_text("utf-8").splitlines():
        command, *names = line.split()
        if command in ("include", "graft"):
            patterns.update(names)
    top = {path.split("/")[0] for path in tracked()}
    assert not [name for name in top if not any(fnmatch.fnmatchcase(name, each) for each in patterns)]


class Installation:
    """The program, installed from its source distribution into an environment of its own.

    The packages that it needs, pip and setuptools too, are those of the tests' environment, without what is
    installed editable there. Nothing is fetched.
    """

    def __init__(self, prefix, home):
        self.prefix, self.home = prefix, home
        self.bin = prefix / ("Scripts" if os.name == "nt" else "bin")

    def make(self, folder):
        """Install the program; `folder` is for temporary files."""
        source = folder / "source"
        for path in tracked():
            target = source / path
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / path, target)
        venv.create(self.prefix)
        site = next(self.prefix.rglob("site-packages"))
        site.joinpath("borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n", "utf-8")
        self.python(
            "-c",
            f"from setuptools import build_meta; build_meta.build_sdist({str(folder)!r})",
            cwd=source,
        )
        shutil.rmtree(source)
        (distribution,) = folder.glob("grabbergui-*.tar.gz")
        self.python(
            "-m", "pip", "install", "-q", "--disable-pip-version-check", "--no-deps", "--no-build-isolation",
            "--no-compile",  # the programs compile what they import
            "--ignore-installed", str(distribution),
        )  # fmt: skip

    def python(self, *arguments, **options):
        return self._run(self.bin / "python", *arguments, **options)

    def grabbergui(self, *arguments, **options):
        return self._run(self.bin / "grabbergui", *arguments, **options)

    def _run(self, program, *arguments, cwd=None, code=0):
        # Nothing of the tests' own surroundings: no PYTHONPATH, no display, no user's folders.
        environment = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("PYTHON", "XDG_", "QT_")) and name not in ("DISPLAY", "WAYLAND_DISPLAY")
        }
        environment |= {"HOME": str(self.home), "GRABBERGUI_INTERFACES": "none", "SHELL": "/bin/bash"}
        done = subprocess.run(
            [str(program), *arguments],
            cwd=cwd or self.home,
            env=environment,
            capture_output=True,
            text=True,
            timeout=2 * PROGRAM,
        )
        assert code is None or done.returncode == code, done.stdout + done.stderr
        return done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The one installation of this run, with a home for each worker."""
    name = "installation"
    installation = Installation(isolation.run_folder() / name, tmp_path_factory.mktemp("home"))
    with isolation.made_once(name) as folder:
        if folder:
            installation.make(tmp_path_factory.mktemp("making"))
    return installation


def test_everything_is_found_in_the_installation(installed):
    paths = json.loads(installed.grabbergui("paths", "--json"))
    del paths["cache"]
    for name, path in paths.items():
        assert Path(path).exists() and Path(path).is_relative_to(installed.prefix), name
    assert (Path(paths["manual"]) / "decisions" / "README.md").is_file()
    assert not list(Path(paths["resources"]).rglob("__pycache__/*.xml"))
    assert (Path(paths["examples"]) / "one_image.py").is_file()
    assert (Path(paths["manual"]) / "images" / "overview.png").is_file()
    assert not list(Path(paths["manual"]).rglob("*-dark.png"))  # the manual in the window is light


def test_the_page_of_the_package_index_says_how_to_install_it(installed):
    text = installed.python("-c", "from importlib import metadata; print(metadata.metadata('grabbergui'))")
    assert "Programming Language :: Python :: 3.14" in text and "Development Status :: 4 - Beta" in text
    assert text.index("pip install grabbergui") < text.index("## Why grabbergui") and "make run" not in text
    links = re.findall(r"\]\(([^)]+)\)|(?:src|srcset|href)=\"([^\"]+)\"", text)
    assert all((one or other).startswith("https://") for one, other in links)


def test_the_example_of_the_readme_runs(installed):
    code = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL)[1]
    assert "import grabbergui" in code and "gige:" in code
    shown = installed.python("-c", code.replace("gige:", "sim:").replace("frames(100)", "frames(3)"))
    assert len(shown.splitlines()) == 3


def test_it_is_added_to_the_desktop_and_to_the_shell(installed):
    for part in ("desktop", "completion"):
        files = [Path(file) for file in json.loads(installed.grabbergui("setup", part, "--json"))]
        assert files and all(file.is_file() and file.is_relative_to(installed.home) for file in files)
    entry = (installed.home / ".local/share/applications/grabbergui.desktop").read_text("utf-8")
    assert str(installed.bin / "grabbergui") in entry
    shown = installed.grabbergui("--complete", "bash", "grabbergui get sim: ExposureTi", ":=")
    assert shown.split() == ["words", "ExposureTime"]


def test_the_doctor_advises_nothing_that_the_installation_lacks(installed):
    findings = json.loads(installed.grabbergui("doctor", "--json", code=None))
    remedies = [each["remedy"] for each in findings if "grabbergui" in each["remedy"]]
    assert not [each["remedy"] for each in findings if re.search(r"\bmake \w+|scripts/", each["remedy"])]
    parser = command_line()
    for remedy in remedies:
        words = shlex.split(re.split(r"   |,| runs ", remedy.removeprefix("sudo "))[0])
        assert words[0] == str(installed.bin / "grabbergui"), remedy
        parser.parse_args(words[1:])


def test_the_window_opens(installed):
    installed.grabbergui("sim:", "--offscreen", "--screenshot", "window.png")
    assert (installed.home / "window.png").stat().st_size > 10_000


def test_its_command_line_needs_no_window(installed):
    shown = installed.python(
        "-c",
        "import sys; sys.modules['PyQt5'] = sys.modules['pyqtgraph'] = None\n"
        "from grabbergui.cli import main; sys.exit(main(['grab', 'sim:', '-n', '2', '--json']))",
    )
    assert json.loads(shown)["frames"] == 2
