"""`python -m studies.atlas` runs the fretting atlas."""

from studies.atlas.commands import atlas

if __name__ == "__main__":
    atlas()
