# SPDX-License-Identifier: Apache-2.0

# The last step of the build loads the Python package, to write its types.
execute_process(COMMAND ${Python_EXECUTABLE} -c "import numpy" RESULT_VARIABLE no_numpy OUTPUT_QUIET ERROR_QUIET)
if(no_numpy)
  message(FATAL_ERROR "TACTEL_PYTHON: ${Python_EXECUTABLE} has no NumPy; get it by apt install python3-numpy, or by pip install numpy, "
                      "or name another interpreter by -DPython_EXECUTABLE=")
endif()
