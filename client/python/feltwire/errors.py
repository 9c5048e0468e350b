"""The errors of the package."""


class Error(RuntimeError):
    """Something failed. The text says what, and the remedy."""


class Refused(Error):
    """The server refuses for good: the token, the scene, the device or a parameter."""


class ServerError(Error):
    """The server is not reachable, not trusted, or full. Trying again may help."""


class FileError(Error):
    """A file cannot be read. The text names the file, the place in it, and the remedy."""


class SceneError(Error):
    """A scene is wrong. The text is the server's: the place in the scene, the error and the remedy."""
