#!/usr/bin/env bash
# The sun of a place and an hour goes the wrong way round in Mitsuba: at noon it stands in the north of Berlin.
#
# Expected: by the documentation of `sunsky` x is north and z is up, so y is west. In Berlin on 21 June the sun is in
# the east at 9 o'clock (azimuth 97 degrees), in the south at 13 (176), in the west at 18 (272). What happens: Mitsuba
# 3.9.1 has it at 83, 4 and 268: its height is right, its azimuth is 180 degrees less the right one. South and north
# are exchanged, east and west are not. So the sky is a mirror image, and shadows go round the wrong way, north and
# south of the equator alike: a rotation by `to_world` puts one hour right, never a day. Nothing is said.
# Remedy: take the azimuth from elsewhere, and set `sun_direction` to cos(a)cos(h), -sin(a)cos(h), sin(h).
# Versions: Mitsuba 3.9.1, astral 3.2 for the sun as it is (PyPI). Source: measured here;
# https://github.com/mitsuba-renderer/mitsuba3 (src/emitters/sunsky.cpp, include/mitsuba/render/sunsky.h)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet mitsuba==3.9.1 astral==3.2
cat >sun.py <<'END'
import datetime
import math

import mitsuba as mi
from astral import Observer
from astral.sun import azimuth, elevation

mi.set_variant("scalar_rgb")


def sun(latitude, longitude, zone, hour):
    """Where the emitter has its sun: azimuth from north (x) towards east (-y), and height, in degrees."""
    x, y, z = mi.traverse(mi.load_dict({
        "type": "sunsky", "latitude": latitude, "longitude": longitude, "timezone": float(zone),
        "year": 2026, "month": 6, "day": 21, "hour": float(hour), "minute": 0.0, "second": 0.0}))["sun_direction"]
    return math.degrees(math.atan2(-y, x)) % 360, math.degrees(math.asin(z))


def off(a, b):
    return abs((a - b + 180) % 360 - 180)


for place, latitude, longitude, zone, hours in [
    ("Berlin", 52.5, 13.4, 2, (9, 13, 18)), ("Sydney", -33.9, 151.2, 10, (9, 12, 15)),
]:
    for hour in hours:
        time = datetime.datetime(2026, 6, 21, hour, tzinfo=datetime.timezone(datetime.timedelta(hours=zone)))
        true = azimuth(Observer(latitude, longitude), time), elevation(Observer(latitude, longitude), time)
        found = sun(latitude, longitude, zone, hour)
        print("Mitsuba", mi.__version__, place, "%02d:00 azimuth %.1f height %.1f;" % (hour, *found),
              "the sun: %.1f and %.1f" % true, flush=True)
        if off(found[0], 180 - true[0]) > 0.3 or abs(found[1] - true[1]) > 0.3:
            raise SystemExit("this has changed")
END
venv/bin/python sun.py 2>&1 | grep "^Mitsuba\|changed"
