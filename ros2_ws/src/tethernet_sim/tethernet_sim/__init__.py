"""Simulator of net, tether, debris and chaser; batch engine; simulator node."""
