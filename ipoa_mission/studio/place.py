"""Parse latitude and longitude, MGRS, or a plus code."""

import re

from ipoa_mission.errors import BadInput, imported


def place_of(words: str) -> tuple[float, float]:
    """Return latitude and longitude [deg].

    >>> place_of("47.397742, 8.545594"), place_of("47.4 S 8.5 W")
    ((47.397742, 8.545594), (-47.4, -8.5))
    """
    text, square = words.strip(), "".join(words.split())
    expected = "expected degrees (47.3977, 8.5456), MGRS (32TMT6569649438) or a whole plus code (8FVC9GXW+36)"
    number = r"([-+]?\d+(?:\.\d*)?)\s*°?\s*"
    if degrees := re.fullmatch(rf"{number}([NS]?)[\s,;]+{number}([EW]?)", text, re.IGNORECASE):
        latitude, longitude = float(degrees[1]), float(degrees[3])
        latitude = -latitude if degrees[2].upper() == "S" else latitude
        longitude = -longitude if degrees[4].upper() == "W" else longitude
    elif re.fullmatch(r"\d{1,2}[C-HJ-NP-X][A-HJ-NP-Z]{2}(\d\d){0,5}", square, re.IGNORECASE):
        mgrs = imported("mgrs", "MGRS needs the library mgrs", "studio")
        try:
            latitude, longitude = map(float, mgrs.MGRS().toLatLon(square.upper()))
        except Exception as error:  # the library's own classes
            raise BadInput(f"{expected}, not {text!r}", place="place") from error
    elif re.fullmatch(r"[23456789CFGHJMPQRVWX]{8}\+[23456789CFGHJMPQRVWX]{2,7}", text, re.IGNORECASE):
        codes = imported("openlocationcode.openlocationcode", "plus codes need openlocationcode", "studio")
        area = codes.decode(text.upper())
        latitude, longitude = float(area.latitudeCenter), float(area.longitudeCenter)
    else:
        raise BadInput(f"{expected}, not {text[:60]!r}", place="place")
    if not (abs(latitude) <= 85 and abs(longitude) <= 180):
        message = f"expected a latitude from -85 to 85 and a longitude from -180 to 180 degrees, not {text}"
        raise BadInput(message, place="place")
    return latitude, longitude
