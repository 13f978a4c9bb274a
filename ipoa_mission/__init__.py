"""Plan an obstacle-free flight, write it as a QGroundControl mission, upload it, and know how long it will fly."""
