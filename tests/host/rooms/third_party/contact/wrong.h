#include <CL/opencl.hpp>
