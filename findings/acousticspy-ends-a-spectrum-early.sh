#!/bin/sh
# acousticspy's spectrum of a recording of two seconds has no tone above a quarter of the sampling rate.
#
# acousticspy 0.6.2, get_fft, single-sided, at 16 kHz. Guess: a tone of 6 kHz, as a propeller has, is in the spectrum of
# any length of recording, up to 8 kHz. Seen: of one second yes; of two the spectrum ends at 4 kHz, of a half second it
# has a second tone at 10 kHz, the mirrored one. It keeps 8000 values, whatever their step. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q acousticspy==0.6.2 numpy==2.3.5 scipy==1.16.3 pandas==2.3.3 matplotlib==3.10.7
cd "$folder"
./venv/bin/python - <<'PY'
from importlib.metadata import version

import numpy as np
from acousticspy.spectra import get_fft

RATE = 16000


def tones(seconds):
    """The end of the spectrum and its tones, in kHz, of 6 kHz recorded for this time."""
    times = np.arange(int(seconds * RATE)) / RATE
    spectrum, frequencies = get_fft(np.sin(2 * np.pi * 6000 * times), RATE)
    loud = [round(float(frequency) / 1000) for frequency in frequencies[np.abs(spectrum) > 0.5]]
    return round(float(frequencies[-1]) / 1000), loud


seen = {seconds: tones(seconds) for seconds in (0.5, 1, 2)}
print(f"acousticspy {version('acousticspy')}, seconds: end of the spectrum and tones in kHz: {seen}")
raise SystemExit(0 if seen == {0.5: (16, [6, 10]), 1: (8, [6]), 2: (4, [])} else 1)
PY
