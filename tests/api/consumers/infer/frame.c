// SPDX-License-Identifier: Apache-2.0
/* The same in C: frame_c NETWORK MISSING. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tactel.h>

int main(int count, char** words) {
  tactel_estimator* network = count > 2 ? tactel_load(words[1]) : NULL;
  tactel_answer answer, all[2];
  float* frame;
  size_t i, inputs;
  if (network == NULL) {
    fprintf(stderr, "%s\n", tactel_error());
    return 2;
  }
  inputs = tactel_inputs(network);
  frame = (float*)malloc(2 * inputs * sizeof *frame);
  for (i = 0; i < 2 * inputs; ++i) frame[i] = 0.05f * (float)(i % inputs + 1);
  answer = tactel_estimate(network, frame, inputs);
  printf("%zu inputs, S = %.9g, %s\n", inputs, answer.slip_index, tactel_status_name(answer.status));
  tactel_estimate_all(network, frame, 2, all);
  if (all[1].slip_index != answer.slip_index || !isnan(answer.slip_upper)) return 3;
  if (tactel_estimate(network, frame, inputs - 1).status != TACTEL_WRONG_SIZE) return 4;
  if (strlen(tactel_error()) != 0) return 5;
  if (tactel_load(words[2]) != NULL || strstr(tactel_error(), words[2]) == NULL) return 6;
  if (tactel_load(NULL) != NULL || strlen(tactel_error()) == 0) return 7;
  tactel_free(NULL);
  tactel_free(network);
  free(frame);
  return 0;
}
