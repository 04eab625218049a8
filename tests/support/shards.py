"""`--shard k/n` of a campaign: every n-th case from k on."""

import argparse


def shard(text: str) -> tuple[int, int]:
    """(k, n) of "k/n" with 0 <= k < n: all n together are every case once."""
    first, _, count = text.partition("/")
    if first.isdigit() and count.isdigit() and int(first) < int(count):
        return int(first), int(count)
    raise argparse.ArgumentTypeError(
        f"{text!r}: expected k/n with k from 0 to n - 1, as 0/2 and 1/2"
    )
