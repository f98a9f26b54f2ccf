"""
Which amplitudes persist?
=========================

The averaged equation of the belt oscillator says how fast each amplitude grows or decays. Its zeros are the
amplitudes that stay.
"""

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator

belt = BeltOscillator(vb=0.42)
motion = ns.averaged_amplitude(belt)
figure = motion.plot()
exact = belt.averaged_amplitude() * belt.N / belt.k
stays = motion.amplitudes[motion.is_stable]
print(f"stays at {stays[0]:.9f} m, by its closed form {exact:.9f} m")
