"""The simulated camera on a network: GVCP and GVSP, the device's side."""
