"""Simulation with MuJoCo: scene, objects, contacts, hand, pile and wrist sensor."""
