QUADROTOR = 2  # MAV_TYPE
#: MAV_TYPE: quadrotor, coaxial, hexa-, octo-, tri-, dodeca-, decarotor.
MULTICOPTERS = frozenset({QUADROTOR, 3, 13, 14, 15, 29, 35})

_CLASSES = {1: "plane", 4: "helicopter", 5: "antenna tracker", 7: "airship", 8: "balloon", 9: "rocket"}
_CLASSES |= {10: "rover", 11: "boat", 12: "submarine", 16: "flapping wing", 17: "kite", 28: "parafoil"}
_CLASSES |= dict.fromkeys(MULTICOPTERS, "multicopter") | dict.fromkeys(range(19, 26), "VTOL")

#: Rover, boat, submarine.
NO_AIRCRAFT = frozenset({10, 11, 12})


def class_name(mav_type: int) -> str:
    """Name a MAV_TYPE.

    >>> class_name(1), class_name(13), class_name(18)
    ('plane', 'multicopter', 'vehicle of MAV_TYPE 18')
    """
    return _CLASSES.get(mav_type, f"vehicle of MAV_TYPE {mav_type}")


def with_article(name: str) -> str:
    """Add "a" or "an".

    >>> with_article("airship"), with_article("PX4 VTOL")
    ('an airship', 'a PX4 VTOL')
    """
    return f"{'an' if name[0] in 'AEIOaeio' else 'a'} {name}"
