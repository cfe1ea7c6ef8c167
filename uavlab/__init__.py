"""uavlab: multirotor flight, estimation and control, to fly with and to learn from."""
