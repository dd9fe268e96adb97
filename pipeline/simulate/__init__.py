"""Where data come from: trajectories, sensors, the closed loop of two FMUs, and files of measured data."""
