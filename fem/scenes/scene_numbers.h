// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"
#include "fem/scenes/shape_numbers.h"

// Numbers of the parts of scenes that the mechanics alone have in this form.

namespace tactel::fem {

template <>
inline constexpr auto numbers<Sensor> = std::tuple{
    Number{"length", "mm", &Sensor::length, some_mm, "mm", false},
    Number{"thickness", "mm", &Sensor::thickness, some_mm, "mm", false},
    Number{"young", "MPa", &Sensor::young, "a number of MPa above 0", "MPa", false},
    Number{"poisson", "1", &Sensor::poisson, "a number with 0 <= poisson <= 0.5", "", false},
    Number{"columns", "", &Sensor::columns, "a whole number of mesh nodes along x", "nodes along x", false, false},
    Number{"rows", "", &Sensor::rows, "a whole number of mesh nodes through the thickness",
           "nodes through the thickness", false, false},
    Number{"grading", "1", &Sensor::grading, "a number above 0 (bottom row height over top row height)",
           "bottom row height over top row height", false},
    Number{"element", "", &Sensor::element, "", "", false, false},
    Number{"tactels", "", &Sensor::tactels, "a whole number of tactels, at least 2", "", false, false},
    Number{"tactel_span", "mm", &Sensor::tactel_span,
           "a number of mm, from the first tactel's middle to the last one's", "mm; None: all that fits", false},
    Number{"tactel_width", "mm", &Sensor::tactel_width, "a number of mm, 0 (a point) or more", "mm; 0: points", false},
    Number{"stress", "", &Sensor::stress, "", "", false, false}};
template <>
inline constexpr std::tuple<> numbers<HeightMap>{};
template <>
inline constexpr auto numbers<PadIndenter> = std::tuple{
    Number{"position", "mm", &PadIndenter::position, "two numbers [x, y] of mm on the pad, [0, 0] in its middle",
           "mm, (x, y)", false, true, "position"},
    Number{"yaw", "degrees", &PadIndenter::yaw, "a number of degrees about z", "degrees", false},
    Number{"tilt", "degrees", &PadIndenter::tilt, "a number of degrees, 0 to 45", "degrees", false},
    Number{"tilt_direction", "degrees", &PadIndenter::tilt_direction,
           "the direction in degrees in which the bottom rises", "degrees", false},
    Number{"young", "MPa", &PadIndenter::young, "a number of MPa above 0, or left out for a rigid object",
           "MPa; None: rigid", false},
    Number{"poisson", "1", &PadIndenter::poisson, "a number with 0 <= poisson <= 0.5", "", false}};

inline bool tilts(const Shape&) { return false; }  ///< as those of pads do (pad_scene.h)

/// Returns the sensor with the span that its tactels have where none is given.
inline Sensor with_span(Sensor sensor) {
  sensor.tactel_span = sensor.span();
  return sensor;
}

}  // namespace tactel::fem
