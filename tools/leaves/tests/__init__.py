"""Properties of leaves, trees and their textures."""
