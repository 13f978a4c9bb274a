"""What the project is measured, generated, fuzzed and flown with: `python -m tools.FOLDER.NAME`, from its root."""

from pathlib import Path

REPOSITORY = Path(__file__).parents[1]
