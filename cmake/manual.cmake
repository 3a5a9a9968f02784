# SPDX-License-Identifier: Apache-2.0

# Writes the manual pages and the completion that the program describes: cmake -DPROGRAM= -DHELP2MAN= -DVERSION= -DFOLDER= -P manual.cmake
function(run_into output)
  execute_process(COMMAND ${ARGN} OUTPUT_FILE ${output} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\n  [a-z]+  " commands "${help}")  # a line each
set(help2man ${HELP2MAN} --no-info --no-discard-stderr --section=1 --source=tactel --version-string=${VERSION})
run_into(${FOLDER}/tactel.1 ${help2man} "--name=simulates a tactile skin and detects incipient slip" ${PROGRAM})
foreach(command ${commands})
  string(STRIP "${command}" command)
  run_into(${FOLDER}/tactel-${command}.1 ${help2man} "--name=see tactel(1)" "${PROGRAM} ${command}")
endforeach()
run_into(${FOLDER}/tactel ${PROGRAM} completion)
