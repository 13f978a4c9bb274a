"""Parse latitude and longitude, MGRS, or a plus code."""

import re

from ipoa_mission.errors import BadInput, imported

DEGREES = re.compile(r"([-+]?\d+(?:\.\d*)?)\s*°?\s*([NS]?)[\s,;]+([-+]?\d+(?:\.\d*)?)\s*°?\s*([EW]?)", re.IGNORECASE)
MGRS = re.compile(r"\d{1,2}[C-HJ-NP-X][A-HJ-NP-Z]{2}(\d\d){0,5}", re.IGNORECASE)
PLUS = re.compile(r"[23456789CFGHJMPQRVWX]{8}\+[23456789CFGHJMPQRVWX]{2,7}", re.IGNORECASE)
EXPECTED = "expected degrees (47.3977, 8.5456), MGRS (32TMT6569649438) or a whole plus code (8FVC9GXW+36)"


def place_of(words: str) -> tuple[float, float]:
    """Return latitude and longitude [deg].

    >>> place_of("47.397742, 8.545594"), place_of("47.4 S 8.5 W")
    ((47.397742, 8.545594), (-47.4, -8.5))
    """
    told = words.strip()
    if found := DEGREES.fullmatch(told):
        latitude, longitude = float(found[1]), float(found[3])
        place = (
            -latitude if found[2].upper() == "S" else latitude,
            -longitude if found[4].upper() == "W" else longitude,
        )
    elif MGRS.fullmatch("".join(told.split())):
        mgrs = imported("mgrs", "MGRS needs the library mgrs", "studio")
        try:
            latitude, longitude = mgrs.MGRS().toLatLon("".join(told.split()).upper())
        except Exception as error:  # the library's own classes
            raise BadInput(f"{EXPECTED}, not {told!r}", place="place") from error
        place = (float(latitude), float(longitude))
    elif PLUS.fullmatch(told):
        codes = imported("openlocationcode.openlocationcode", "plus codes need openlocationcode", "studio")
        area = codes.decode(told.upper())
        place = (float(area.latitudeCenter), float(area.longitudeCenter))
    else:
        raise BadInput(f"{EXPECTED}, not {told[:60]!r}", place="place")
    if not (abs(place[0]) <= 85 and abs(place[1]) <= 180):
        message = f"expected a latitude from -85 to 85 and a longitude from -180 to 180 degrees, not {told}"
        raise BadInput(message, place="place")
    return place
