"""The simulated world: scene, objects, contacts, hand, pile and wrist sensor, all on MuJoCo."""
