#pragma once
#include <string>
#include <vector>

#include "host/device/executor.h"

namespace tactel::host {

/// How much of the table of extremes: all of it takes minutes, `quick` a few seconds.
struct ExtremesOptions {
  bool quick = false;  ///< short paths instead of long ones, and no mesh beyond 123 x 33
};

/// What one solver made of an extreme.
struct ExtremeAnswer {
  bool solved = false;     ///< every step met its tolerance
  bool fell_back = false;  ///< the exact fallback had to help
  int iterations = 0;      ///< most in a step
  double residual = 0;     ///< worst of the certificates
  double off = 0;          ///< base forces beside the reference's (fem::base_force_difference); NaN where one is NaN
  double seconds = 0;
};

/// One line of the table.
struct Extreme {
  std::string group, name;
  ExtremeAnswer fp32, fp64, reference;
  std::string told;  ///< what the user is told beside the answer
};

/// Every extreme by the batched solver in fp32 and fp64 and by the reference.
std::vector<Extreme> scene_extremes(Executor& executor, const ExtremesOptions& options, const Progress& progress = {});

/// Statements about long paths, several solutions, and wrong input: a question, and what came out.
struct ExtremeFinding {
  std::string question, found;
  bool good = false;  ///< as it should be
};
std::vector<ExtremeFinding> extreme_findings(Executor& executor, const ExtremesOptions& options);

std::string extremes_table(const std::vector<Extreme>& extremes);
std::string findings_table(const std::vector<ExtremeFinding>& findings);

}  // namespace tactel::host
