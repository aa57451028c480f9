"""The one error of a recording that cannot be used: a sentence for the person who made it."""


class RecordingError(ValueError):
    """A recording, or its description, cannot be read or used; the message is one sentence that says why.

    Problems of the data are of this class, whatever a library underneath raised. A wrong argument of a function is a
    plain ``ValueError`` or ``TypeError``, as everywhere.
    """


def first_sentence(error: BaseException, limit: int = 200) -> str:
    """First line of what another library had to say, cut to a readable length."""
    text = " ".join(str(error).split("\n", 1)[0].split()) or type(error).__name__
    text = "".join(letter if letter.isprintable() else "?" for letter in text)
    return text if len(text) <= limit else text[: limit - 3] + "..."
