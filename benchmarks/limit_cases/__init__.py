"""Cases of `benchmarks.limits` beside its seeded faults; what is right to say is known without a limit.

Each case states where its size is from: physics, the data of sensors, or what other simulators do. None reads
a limit's value.
"""
