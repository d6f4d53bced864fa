"""The equations of the project in plain NumPy, to hold the compiled simulator against.

Everything here is written from the published equations and from nothing else: Pereira, Ambrosio and
Ramalho, ECCM 2010 (clearance joint, force laws), ANSI/ASME B29.1 (tooth form). Speed is no aim.

geometry    a circle against the seven regions of a sprocket tooth
force_law   one contact's normal force, its derivative and its energy
dynamics    the accelerations of a drive of two sprockets
path        a path in time, with the memory each contact keeps from its onset
generator   the start of the paper's drive, to any number of digits
states      random states with contacts in every region of the tooth
"""
