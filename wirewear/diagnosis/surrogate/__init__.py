"""The fast forward model: loops and wear under any circumstances, computed from the wear states of one nominal run.

The nominal run is a finite element run of the test as it is stated; its wear states describe the contact at each worn
volume.
"""
