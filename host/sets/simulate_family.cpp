#include "host/sets/simulate_family.h"

#include "host/sets/set_simulator.h"

namespace tactel::host {

ContactSet simulate_family(Executor& executor, const SceneFamily& family, Precision precision, double tolerance) {
  const SceneSource source = source_of(family);
  return SetSimulator(executor, source, {precision, tolerance}).simulate(0, source.contacts());
}

}  // namespace tactel::host
