"""Settings become words of the command line."""

from __future__ import annotations

import json
import os
from typing import Any

from ._errors import SettingError
from ._fogbow import flags


def words(command: str, settings: dict[str, Any]) -> tuple[list[str], float | None]:
    """The words for `settings` of `command`, and the frame of a sequence that they name."""
    known = {name.replace("-", "_"): (name, has_value) for name, has_value, _ in flags(command)}
    settings = {name: value for name, value in settings.items() if value is not None}
    frame = settings.pop("frame", None) if command == "render" else None
    found = [f"--set={key}={toml(value)}" for key, value in settings.pop("set", {}).items()]
    for name, value in settings.items():
        if name not in known:
            raise SettingError(_unknown(name, known))
        flag, has_value = known[name]
        if has_value:
            found.append(f"--{flag}={_word(name, value)}")
        elif value is True or value is False:
            found.extend([f"--{flag}"] * value)
        else:
            raise SettingError(f"{name}={value!r}: give True or False")
    return found, frame if frame is None else float(frame)


def _unknown(name: str, known: dict[str, Any]) -> str:
    from difflib import get_close_matches

    near = get_close_matches(name, known, 1)
    right = f"did you mean {near[0]}?" if near else "fogbow.settings() lists those that there are"
    return f"{name} is no setting; {right}"


def _word(name: str, value: Any) -> str:
    """A value as it stands behind a flag."""
    value = plain(value)
    if isinstance(value, bool):
        raise SettingError(f"{name}={value!r}: give a value")
    if isinstance(value, (list, tuple)):
        if name in ("size", "resolution") and len(value) == 2:
            return "x".join(map(str, value))
        if name == "crop" and len(value) == 4:
            x, y, width, height = value
            return f"{x},{y},{width}x{height}"
        return ",".join(str(plain(item)) for item in value)
    return str(value)


def plain(value: Any) -> Any:
    """A value of Python's own types: numbers and arrays of NumPy become numbers and lists, paths text."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return os.fspath(value) if hasattr(value, "__fspath__") else value


def toml(value: Any) -> str:
    """A value in TOML."""
    value = plain(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, (bool, str)):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)
