"""System descriptions, shapes, frames, parameters, mission rules, capture quality."""
