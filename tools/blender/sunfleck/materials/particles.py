"""Particle info of instances, as in Cycles.

In go an instance of the graph and a frame, out come four numbers. Invariant: an instance without a
particle has the values of Cycles' first, empty particle.
"""

import bpy

WORD = 0xFFFFFFFF


def answer(output: str, instance: bpy.types.DepsgraphObjectInstance, frame: float) -> tuple[float, ...]:
    system = instance.particle_system if instance.is_instance else None
    number = instance.persistent_id[0] if system else 0
    # Cycles has no child particles.
    particle = system.particles[number] if system and 0 <= number < len(system.particles) else None
    if output == "Random":
        return (hash_of(number if particle else 0) / WORD,) * 3 + (1.0,)
    if particle is None:
        return (0.0, 0.0, 0.0, 1.0)
    if output in {"Location", "Velocity", "Angular Velocity"}:
        return (*getattr(particle, output.lower().replace(" ", "_")), 1.0)
    found = {
        "Index": lambda: number, "Age": lambda: frame - particle.birth_time,
        "Lifetime": lambda: particle.lifetime, "Size": lambda: particle.size,
    }[output]()
    return (float(found),) * 3 + (1.0,)


def hash_of(number: int) -> int:
    """Cycles' `hash_uint2(number, 0)`, by Jenkins (lookup3)."""
    a = b = c = (0xDEADBEEF + (2 << 2) + 13) & WORD
    a = (a + number) & WORD

    def turned(value: int, bits: int) -> int:
        return ((value << bits) | (value >> (32 - bits))) & WORD

    for bits in ((14, 11, 25), (16, 4, 14), (24, 0, 0)):
        c = ((c ^ b) - turned(b, bits[0])) & WORD
        if bits[1]:
            a = ((a ^ c) - turned(c, bits[1])) & WORD
            b = ((b ^ a) - turned(a, bits[2])) & WORD
    return c
