"""A text file in blocks of whole lines, of which one at a time is in memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from geosurf.errors import FormatError
from geosurf.read._guard import check_size, opened, read_some, refuse_beyond_memory

BLOCK = 1 << 18  # bytes at a time: they and their numbers stay in the cache
WIDE_MARKS = (b"\xff\xfe", b"\xfe\xff", b"\x00\x00\xfe\xff")  # UTF-16 and UTF-32
BYTE_ORDER = b"\xef\xbb\xbf"


class TextBlocks:
    r"""
    Blocks of a text in UTF-8 or else Latin-1, with lines that end by a line feed.

    Iteration yields each block with the number of its first line. Blocks end at line ends, so
    that no number is cut in two.

    Parameters
    ----------
    path : pathlib.Path
    final_line_end : bool
        Whether the last line needs a line end. Without it a last number may be cut short ("1603.25"
        and "1603.2" both parse), so it is refused where the format has no other end mark.

    Attributes
    ----------
    size : int
        Bytes of the file.
    head : str
        The first block: at least `BLOCK` bytes, or the whole text.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "a.txt"
    >>> _ = file.write_bytes(b"name\r\n1 2\r\n3 4\r\n")
    >>> blocks = TextBlocks(file)
    >>> blocks.skip(5)
    >>> list(blocks)
    [(2, '1 2\n3 4\n')]
    """

    def __init__(self, path: Path, *, final_line_end: bool = True) -> None:
        self.path = path
        self.size = 0
        self._blocks = self._decoded(final_line_end)
        self.head = next(self._blocks)
        self._line = 1

    def skip(self, n: int) -> None:
        """Leave out the first characters of the head, before blocks are taken."""
        self._line += self.head.count("\n", 0, n)
        self.head = self.head[n:]

    def __iter__(self) -> Iterator[tuple[int, str]]:
        # the head is not kept: its memory would stay with that of the values
        block: str | None = self.head
        self.head = ""
        while block is not None:
            yield self._line, block
            self._line += block.count("\n")
            block = next(self._blocks, None)

    def _decoded(self, final_line_end: bool) -> Iterator[str]:
        """Yield blocks as text; the first one holds more than white space."""
        waiting, n_line = "", 1
        for data, is_last in self._pieces():
            # UTF-8 first, which other encodings seldom pass by chance; Latin-1 takes any byte
            try:
                text = data.decode("utf-8")
            except UnicodeDecodeError:
                text = data.decode("latin-1")
            if "\r" in text:
                # line ends of Windows and of old Macs
                text = text.replace("\r\n", "\n").replace("\r", "\n")
            waiting += text
            blank = not waiting or waiting.isspace()
            if is_last and final_line_end and not blank and not waiting[-1].isspace():
                raise FormatError(
                    f"{self.path}, line {n_line + waiting.count(chr(10))}: the last line has no "
                    "line end, so the file may be truncated. Export it again, or add a line end "
                    "if the file is complete."
                )
            if n_line == 1 and blank:
                if is_last:
                    raise FormatError(
                        f"{self.path}: the file contains only white space. Export it again."
                    )
                continue
            n_line += waiting.count("\n")
            if waiting:
                yield waiting
            waiting = ""

    def _pieces(self) -> Iterator[tuple[bytes, bool]]:
        """Yield whole lines of bytes, and whether they are the last ones."""
        parts: list[bytes] = []
        n_read = 0
        with opened(self.path) as (file, self.size):
            refuse_beyond_memory(self.path, self.size)
            # one byte more than expected shows that the file has grown meanwhile
            while data := read_some(self.path, file, min(BLOCK, self.size - n_read + 1)):
                self._refuse_no_text(data, n_read)
                text = data if n_read else data.removeprefix(BYTE_ORDER)
                n_read += len(data)
                # a carriage return at the end may belong to a line end of Windows
                cut = max(text.rfind(b"\n"), text.rfind(b"\r", 0, len(text) - 1)) + 1
                if cut:
                    yield b"".join([*parts, text[:cut]]), False
                    parts = []
                parts.append(text[cut:])
        check_size(self.path, self.size, n_read)
        yield b"".join(parts), True

    def _refuse_no_text(self, data: bytes, before: int) -> None:
        """Refuse zero bytes; wide texts have them between letters, and get their own sentence."""
        if before == 0 and data.startswith(WIDE_MARKS):
            raise FormatError(
                f"{self.path}: the text is in UTF-16 or UTF-32. Save the file as UTF-8."
            )
        if b"\0" in data:
            raise FormatError(
                f"{self.path}: byte {before + data.index(0)} is zero, so this is not a text file. "
                "Set format= to its format."
            )
