"""Program with a loaded scene: `sunfleck serve`, through a pipe.

In go requests, out come jobs with the interface of a run. Invariant: one scene a process; a newer request
cancels the current one.
"""

import json
import math
import queue
import subprocess

import numpy

from .evaluated import places
from .render import WARNING, Process, drained

# Far clipping distance in place of infinity, which JSON lacks.
FARTHEST_M = 1e30


class Service(Process):
    """Running program."""

    def __init__(self, executable, path, arguments=()):
        self.jobs, self.number = {}, 0
        super().__init__(executable, "serve", str(path), *arguments, stdin=subprocess.PIPE)

    def _read_events(self):
        """Events belong to the job that is answered next."""
        for line in self.process.stdout:
            news = json.loads(line)
            is_answer = news["event"] == "answered"
            number = news["id"] if is_answer else min(list(self.jobs), default=None)
            job = self.jobs.get(number)
            if job is None:
                continue
            job.events.put(news)
            if is_answer:
                del self.jobs[number]
                job.answer = news

    def is_alive(self):
        return self.process.poll() is None

    def render(self, arguments, camera=None):
        """Requests a picture by flags of `render`; `camera` is from `viewer`, or None for the file's."""
        self.number += 1
        job = self.jobs[self.number] = Job(self, self.number)
        self.say({"id": job.number, "render": [str(one) for one in arguments], **({"camera": camera} if camera else {})})
        return job

    def end(self):
        """Cancels the current picture."""
        self.say({})

    def say(self, request):
        try:
            self.process.stdin.write(json.dumps(request) + "\n")
            self.process.stdin.flush()
        except OSError:
            # The program has ended; jobs will notice.
            pass

    def close(self):
        """Ends the program, and the current picture."""
        try:
            self.process.stdin.close()
        except OSError:
            pass
        self.process.terminate()
        self.wait()


class Job:
    """Requested picture; see `render.Run`."""

    def __init__(self, service, number):
        self.service, self.number, self.events, self.answer = service, number, queue.SimpleQueue(), None
        self.first = len(service.complaints)

    def news(self):
        return drained(self.events)

    def is_over(self):
        return self.answer is not None or not self.service.is_alive()

    def cancel(self):
        if not self.is_over():
            self.service.end()

    def wait(self):
        """0 if there is a picture."""
        return 0 if self.answer is not None and self.answer["outcome"] == "rendered" else 1

    def error(self):
        if self.answer is None:
            return "".join(self.service.complaints).strip() or "sunfleck ended"
        return self.answer.get("error", "")

    def warnings(self):
        found = (WARNING.search(line) for line in self.service.complaints[self.first :])
        return [warning[0] for warning in found if warning]


def viewer(world_from_camera, said):
    """Camera for `Service.render`, from a 4x4 matrix of Blender and a lens of a glTF camera."""
    matrix = places.in_gltf(numpy.asarray(world_from_camera, float)[None], looks=True)[0]
    lens, own = said[said["type"]], said.get("extras", {}).get("sunfleck_camera", {})
    clip = [lens.get("znear", 0.0), lens.get("zfar", FARTHEST_M)]
    found = {"matrix": matrix.T.ravel().tolist(), "shift": own.get("shift", [0.0, 0.0]), "clip_m": clip}
    if said["type"] == "orthographic":
        return {**found, "height_m": 2.0 * lens["ymag"]}
    found["fov_deg"] = math.degrees(lens["yfov"])
    if "fstop" in own and "focus_distance" in own:
        found["aperture"] = {
            "f_stop": own["fstop"],
            "focus_distance_m": own["focus_distance"],
            "sensor_width_m": 1e-3 * own.get("sensor_width_mm", 36.0),
            "blades": own.get("blades", 0),
        }
    return found
