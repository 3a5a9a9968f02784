// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scenes to stresses, sweeps to sets, sets to networks.
#include <tactel/pad.h>
#include <tactel/pad_step.h>
#include <tactel/scene.h>
#include <tactel/solve.h>
#include <tactel/sweep.h>
#include <tactel/train.h>
