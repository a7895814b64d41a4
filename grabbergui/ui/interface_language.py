"""The language of the window: which there are, and which one is spoken."""

from __future__ import annotations

from importlib import resources

from PyQt5.QtCore import (
    QCoreApplication,
    QLibraryInfo,
    QLocale,
    QObject,
    QTranslator,
)

from grabbergui.core.errors import UsageError
from grabbergui.models.language import set_translator

WRITTEN_IN = "en"
"The language of the texts in the sources."
_PREFIX, _SUFFIX = "grabbergui_", ".qm"


def languages() -> list[str]:
    """Return the codes of the languages available."""
    folder = resources.files("grabbergui.resources") / "translations"
    names = [entry.name for entry in folder.iterdir() if entry.name.endswith(_SUFFIX)]
    return sorted({WRITTEN_IN, *(name[len(_PREFIX) : -len(_SUFFIX)] for name in names)})


def speak(app: QCoreApplication, language: str | None = None) -> str:
    """Translate windows made from now on; None is the desktop's language. Return the code of the language.

    Existing windows keep their language. Raises UsageError for an unknown language.
    """
    known = languages()
    if language is not None and language not in known:
        raise UsageError(f"there is no language '{language}'; there are {', '.join(known)}")
    chosen = language or _of_desktop(known)
    for before in app.findChildren(QTranslator):
        app.removeTranslator(before)
        before.deleteLater()
    translators = [] if chosen == WRITTEN_IN else [_of_qt(chosen, app), _ours(chosen, app)]
    for translator in translators:
        app.installTranslator(translator)
    locale = QLocale(chosen)
    QLocale.setDefault(locale)  # for Qt's own fields
    set_translator(QCoreApplication.translate if translators else None, locale.decimalPoint())
    return chosen


def _of_desktop(known: list[str]) -> str:
    """Return the first of the desktop's languages that is available."""
    wanted = [name.replace("_", "-").split("-")[0].lower() for name in QLocale.system().uiLanguages()]
    return next((language for language in wanted if language in known), WRITTEN_IN)


def _of_qt(language: str, parent: QObject) -> QTranslator:
    """Return the translator of Qt's own dialogs."""
    translator = QTranslator(parent)
    translator.load(f"qtbase_{language}", QLibraryInfo.location(QLibraryInfo.TranslationsPath))
    return translator


def _ours(language: str, parent: QObject) -> QTranslator:
    translator = QTranslator(parent)
    file = resources.files("grabbergui.resources") / "translations" / f"{_PREFIX}{language}{_SUFFIX}"
    with resources.as_file(file) as path:
        translator.load(str(path))
    return translator
