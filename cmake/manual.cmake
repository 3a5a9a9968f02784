# SPDX-License-Identifier: Apache-2.0

# Writes the manual pages that the program describes: cmake -DPROGRAM= -DHELP2MAN= -DVERSION= -DDOCS= -DEXAMPLES= -DFOLDER= -P manual.cmake
# DOCS, EXAMPLES: the folders docs/ and examples/ of the help.
function(run output)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE out COMMAND_ERROR_IS_FATAL ANY)
  set(${output} "${out}" PARENT_SCOPE)
endfunction()

# Writes the page of a command (words; none: of the program), and those of its commands.
function(write_pages)
  list(JOIN ARGN " " words)
  string(STRIP "${PROGRAM} ${words}" called)
  list(JOIN ARGN "-" page)
  string(REGEX REPLACE "-$" "" page "tactel-${page}")
  run(help ${PROGRAM} ${ARGN} --help)
  string(REGEX REPLACE "\nUsage:.*" "" about "${help}")
  string(REPLACE "\n" " " about "${about}")
  string(REGEX REPLACE "^tactel: |[.] .*" "" about "${about}")
  file(WRITE ${FOLDER}/included "[NAME]\n${page} \\- ${about}\n\n"
       "[SEE ALSO]\nThe folders that the help calls docs/ and examples/ are ${DOCS} and ${EXAMPLES}.\n")
  run(text ${HELP2MAN} --no-info --no-discard-stderr --section=1 --source=tactel --version-string=${VERSION}
      --include=${FOLDER}/included "${called}")
  if(NOT help MATCHES "OPTIONS. COMMAND")  # the groups of options
    string(FIND "${text}" "\n.SS " groups)
    string(SUBSTRING "${text}" 0 ${groups} about)
    string(SUBSTRING "${text}" ${groups} -1 text)
    string(PREPEND text "${about}\n.SH OPTIONS")
  endif()
  string(TOUPPER "${page}" title)
  string(REGEX REPLACE "\n.TH [^ ]+ " "\n.TH ${title} " text "${text}")
  file(WRITE ${FOLDER}/${page}.1 "${text}")
  if(help MATCHES "OPTIONS. COMMAND")
    string(REGEX MATCHALL "\n  [a-z-]+  " commands "${help}")  # a line each
    foreach(word IN LISTS commands)
      string(STRIP "${word}" word)
      write_pages(${ARGN} ${word})
    endforeach()
  endif()
endfunction()

file(REMOVE_RECURSE ${FOLDER})
write_pages()
file(REMOVE ${FOLDER}/included)
