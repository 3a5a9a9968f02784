// SPDX-License-Identifier: Apache-2.0
#pragma once
// A network and what is done with its parts.
#include "nn/bound.h"
#include "nn/input_scaling.h"
#include "nn/metrics.h"
#include "nn/weights.h"
