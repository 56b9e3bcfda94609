"""Layouts: the controls of the registry as faders, pads and buttons for tablets (TouchOSC, Open Stage Control)."""
