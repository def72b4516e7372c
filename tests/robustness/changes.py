"""One change at random of a file's bytes, words or lines, as Hypothesis draws it."""

import re

from hypothesis import strategies as st

#: What stands where something else is expected.
ODD = (
    *("nan", "inf", "-inf", "-1", "0", "1e400", "-1e-400", "9" * 400, "9" * 5000, "1_000", "1e5", "0x10", "true"),
    *("", '""', '"[/]"', "[]", "[[]]", "{}", "{a=1}", "[" * 3000, "{" * 3000, "'", '"', "\\", "\0", "\x7f", "\u202e"),
    *("µ", "１", "../..", "/etc/passwd", "<script>", "%n%s", "1979-05-27", "07:32:00", ",", ";", "\t", "\n", "\r"),
    *("#", "=", "x" * 20_000),
)


#: Line ends, separators and encodings of others.
RECODED = (
    lambda data: data.decode("latin-1").encode("utf-16"),
    lambda data: data.decode("latin-1").encode("utf-8-sig"),
    lambda data: data.replace(b"\n", b"\r"),
    lambda data: data.replace(b"\n", b"\r\n"),
    lambda data: data.replace(b",", b";"),
    lambda data: data.replace(b".", b","),
)


#: What is put in or in place of a word.
odd_words = st.sampled_from(ODD).map(str.encode) | st.text(max_size=20).map(
    lambda text: text.encode("utf-8", "replace")
)


def places(data: bytes) -> st.SearchStrategy[tuple[int, int, int]]:
    """Three places in a file, the first two in order."""
    one = st.integers(0, len(data))
    return st.tuples(one, one, one).map(lambda three: (min(three[:2]), max(three[:2]), three[2]))


def flipped(data: bytes) -> st.SearchStrategy[bytes]:
    """One bit changed."""
    whole = int.from_bytes(data)
    return st.integers(0, 8 * len(data) - 1).map(lambda bit: (whole ^ (1 << bit)).to_bytes(len(data)))


def reworded(data: bytes) -> st.SearchStrategy[bytes]:
    """A word or number replaced by something odd, or by another word of the file."""
    words = list(re.finditer(rb"[\w.+-]+", data))
    new = odd_words | st.sampled_from([word[0] for word in words])
    return st.builds(lambda old, text: data[: old.start()] + text + data[old.end() :], st.sampled_from(words), new)


def reordered(data: bytes) -> st.SearchStrategy[bytes]:
    """A line left out, moved or doubled."""
    lines = data.split(b"\n")
    last = len(lines) - 1

    def moved(line: int, to: list[int]) -> bytes:
        others = lines[:line] + lines[line + 1 :]
        for place in to:
            others.insert(place, lines[line])
        return b"\n".join(others)

    return st.builds(moved, st.integers(0, last), st.lists(st.integers(0, last), max_size=2))


def changed(data: bytes) -> st.SearchStrategy[bytes]:
    """One mutation of a file."""
    anywhere = places(data)
    found = [
        anywhere.map(lambda at: data[: at[0]] + data[at[1] :]),
        anywhere.map(lambda at: data[: at[2]] + data[at[0] : min(at[1], at[0] + 50_000)] + data[at[2] :]),
        st.builds(lambda at, text: data[: at[0]] + text + data[at[0] :], anywhere, odd_words),
        reordered(data),
        st.sampled_from(RECODED).map(lambda recoded: recoded(data)),
    ]
    found += [flipped(data)] if data else []
    found += [reworded(data)] if re.search(rb"[\w.+-]", data) else []
    return st.one_of(found)
