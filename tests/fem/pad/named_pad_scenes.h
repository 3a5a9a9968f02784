// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <vector>

#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_scene.h"

namespace tactel::fem {

// Six scenes on stated cells, whose totals an independent program for frictional contact gives alike (conjugate
// gradients for pressure, another iteration for friction).

inline PadScene scene_of(const PadShape& shape, double depth, double H, double nu, double mu,
                         std::vector<std::array<double, 3>> drags) {
  PadScene scene;
  scene.sensor = {.tactels = {3, 3}, .pitch = {1, 0.5}, .thickness = H, .young = 1, .poisson = nu};
  scene.indenter.shape = shape;
  scene.friction = mu;
  scene.load = {.indentation = {depth}, .indentation_steps = 2, .drags = std::move(drags)};
  return scene;
}

/// Half the sides of the grid of 16 x 16 cells, and what each step must give: P, Qx, Qy, M, S, sticking cells, touching
/// cells. `stress`: sigma_z, tau_x, tau_y of the last step at (0, 0) and (1, 0.5).
struct NamedScene {
  const char* name;
  PadScene scene;
  double x, y;
  std::vector<std::array<double, 7>> steps;
  std::vector<double> stress;

  PadCells cells() const { return {.n = 16, .hx = x / 8, .hy = y / 8}; }
};

inline PadScene tilted_punch() {
  PadScene scene = scene_of(Punch{1.5, 0.5}, .12, 2.5, .4, .6, {{0, .05, 0}, {0, .1, 0}});
  scene.indenter.tilt = 3;
  scene.indenter.tilt_direction = 30;
  return scene;
}

inline std::vector<NamedScene> named_scenes() {
  return {{"sphere_drag",
           scene_of(Sphere{8}, .25, 2, .45, .5, {{.05, .02, .01}, {.1, .04, .03}, {.1, .1, .05}}),
           1.6,
           1.6,
           {{.41176, 0, 0, 0, 0, 112, 120},
            {1.56827, 0, 0, 0, 0, 224, 232},
            {1.56745, .21032, .08429, .08244, .3163, 201, 232},
            {1.56503, .38148, .15408, .19007, .6008, 149, 232},
            {1.56332, .34231, .35608, .25751, .7429, 124, 233}},
           {-.14651, .00635, .00615, -.11374, .04133, .02584}},
          {"thin_twist",
           scene_of(Paraboloid{{20, 20}}, .1, 1, .5, .8, {{0, 0, .05}, {0, 0, .15}, {.2, 0, .15}}),
           2.24,
           2.24,
           {{},
            {3.30187, 0, 0, 0, 0, 148, 192},
            {3.18701, 0, 0, .86460, .2901, 120, 192},
            {2.93673, 0, 0, 1.74026, .6393, 80, 188},
            {2.56138, 1.04249, .09702, .98002, .7047, 66, 182}},
           {-.33969, .03186, -.01097, -.27130, .09894, .07221}},
          {"ellipsoid_oblique",
           scene_of(Paraboloid{{12, 4}}, .2, 3, .3, .3, {{.02, .03, 0}, {.05, .06, .02}, {.02, 0, .02}}),
           1.6,
           .96,
           {{},
            {.53868, 0, 0, 0, 0, 132, 220},
            {.53535, .04641, .07312, -.00086, .5393, 94, 219},
            {.53165, .09132, .10840, .02366, .9203, 25, 220},
            {.53130, .01376, -.05114, .01885, .3877, 119, 222}},
           {-.03241, .00017, -.00050, -.02526, .00554, .00305}},
          {"rounded_punch_back",
           scene_of(Punch{2, 1}, .2, 2, .49, 1.2, {{.2, 0, 0}, {.4, 0, 0}, {.1, 0, 0}}),
           2.56,
           2.56,
           {{},
            {5.61767, 0, 0, 0, 0, 192, 208},
            {5.57987, 1.49716, 0, 0, .2236, 188, 208},
            {5.53080, 2.88600, 0, 0, .4348, 166, 202},
            {5.54171, .61252, 0, 0, .0921, 192, 208}},
           {}},
          {"tilted_punch",
           tilted_punch(),
           2,
           2,
           {{},
            {.36817, .00265, .00157, -.00003, .0140, 92, 94},
            {.36721, .00544, .13136, -.07774, .6113, 44, 93},
            {.36599, .00579, .20514, -.14838, .9361, 9, 96}},
           {}},
          {"cone_curved",
           scene_of(Cone{75}, .2, 1.5, .3, .4, {{.02, 0, 0}, {.04, .02, .05}, {.04, .06, .1}}),
           .64,
           .64,
           {{},
            {.14896, 0, 0, 0, 0, 76, 148},
            {.14819, .01927, 0, 0, .3251, 70, 152},
            {.14736, .03054, .01518, .00629, .7222, 42, 155},
            {.14663, .02369, .03730, .00713, .9027, 22, 155}},
           {-.03989, .00111, .00180, -.01500, .00891, .00527}}};
}

}  // namespace tactel::fem
