#pragma once
/// Moves a camera by mouse and keys.

#include "camera.h"
#include "input.h"

namespace lockstone::demo {

/// Right drag orbits, middle drag pans, the wheel zooms; WASD fly, Q and E go down and up, left shift makes it faster.
/// `viewport_height` [px], `seconds` since the last call.
void drive_camera(Camera& camera, const Input& input, float viewport_height, float seconds);

} // namespace lockstone::demo
