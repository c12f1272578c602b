"""Exceptions; their messages are those of the command."""


class Error(Exception):
    """A failure of fogbow: one sentence with what was found and what would be right."""


class SettingError(Error, ValueError):
    """A setting, or a key of a scene, is unknown or out of range."""


class FileError(Error, OSError):
    """A file, or a grid in it, cannot be read, written or used."""
