"""Makes the README's moving picture from a mission's report: ``python -m docs.moving_picture REPORT.html OUTPUT.gif``.

Needs a browser (Debian: chromium-headless-shell); nothing else here imports this.
"""

from __future__ import annotations

import argparse
import io
import tempfile
from pathlib import Path

from PIL import Image

from tests import browser

WIDTH, HEIGHT, COLOURS = 760, 700, 48
STEP_S, FRAME_MS, LAST_FRAME_MS = 0.75, 90, 2500


def frames(report: Path, view: str) -> list[Image.Image]:
    """The stage of a report, from launch to the end."""
    program = browser.found()
    if program is None:
        raise SystemExit(f"no browser here; looked for {', '.join(browser.NAMES)}")
    made, moment = [], 0.0
    with tempfile.TemporaryDirectory() as folder, browser.browser(program, Path(folder)) as page:
        page.open(report, width=WIDTH, height=HEIGHT)
        end = float(page.value("document.querySelector('input[type=range]').max"))
        while moment < end + STEP_S:
            page.open(report, width=WIDTH, height=HEIGHT, part=f"t={min(moment, end):.2f}&view={view}")
            box = page.value(
                "(() => { const r = document.querySelector('canvas').getBoundingClientRect();"
                " return [r.left, r.top, r.right, r.bottom] })()"
            )
            made.append(Image.open(io.BytesIO(page.picture())).convert("RGB").crop(tuple(map(round, box))))
            moment += STEP_S
    return made


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("report", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--view", default="beside", choices=("beside", "ahead", "chaser"))
    options = parser.parse_args()
    pictures = frames(options.report, options.view)
    palette = pictures[-1].quantize(COLOURS)
    first, *rest = [picture.quantize(COLOURS, palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    times = [FRAME_MS] * len(rest) + [LAST_FRAME_MS]
    first.save(options.output, save_all=True, append_images=rest, duration=times, loop=0, optimize=True)


if __name__ == "__main__":
    main()
