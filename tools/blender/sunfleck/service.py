"""The program with a scene that stays loaded: `sunfleck serve`, told by a pipe.

In go pictures that are wanted, out come jobs, which one asks how they are as one asks a run of the program.
Invariant: one scene a process; a newer picture ends the one under way.
"""

import json
import math
import queue
import subprocess

import numpy

from .evaluated import places
from .render import WARNING, Process, drained

# So far away that nothing is behind it: JSON has no infinity.
FARTHEST_M = 1e30


class Service(Process):
    """The program, for as long as it is wanted."""

    def __init__(self, executable, path, arguments=()):
        self.jobs, self.number = {}, 0
        super().__init__(executable, "serve", str(path), *arguments, stdin=subprocess.PIPE)

    def _read_events(self):
        """Events are of the job that is answered next."""
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
        """A picture by flags of `render`; `camera` is of `viewer`, or the file's own."""
        self.number += 1
        job = self.jobs[self.number] = Job(self, self.number)
        self.say({"id": job.number, "render": [str(one) for one in arguments], **({"camera": camera} if camera else {})})
        return job

    def end(self):
        """Nobody wants the picture under way."""
        self.say({})

    def say(self, request):
        try:
            self.process.stdin.write(json.dumps(request) + "\n")
            self.process.stdin.flush()
        except OSError:
            # It has ended; jobs find that out.
            pass

    def close(self):
        """What is under way is ended too."""
        try:
            self.process.stdin.close()
        except OSError:
            pass
        self.process.terminate()
        self.wait()


class Job:
    """A picture that was asked for; see `render.Run`."""

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
        """Nought if there is a picture."""
        return 0 if self.answer is not None and self.answer["outcome"] == "rendered" else 1

    def error(self):
        if self.answer is None:
            return "".join(self.service.complaints).strip() or "sunfleck ended"
        return self.answer.get("error", "")

    def warnings(self):
        found = (WARNING.search(line) for line in self.service.complaints[self.first :])
        return [warning[0] for warning in found if warning]


def viewer(world_from_camera, said):
    """A camera for `Service.render`: a 4x4 matrix of Blender's, and its lens as a camera of glTF has it."""
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
