# Read by ctest after the lists of tests that the programs gave: the labels of each.
#   unit       needs no OpenCL device      device  needs one (PoCL is enough)
#   reference  mechanics and networks      hw      sensors
#   slow       takes more than five seconds of a processor
#   usb_guest  a kernel in a virtual machine
#   nightly    run by scripts/nightly alone

# A regular expression of the tests that are slow: `ctest --preset release -LE slow` leaves them out.
set(slow "^(ClosedForms|GapReferenceRandom|IndependentContact|Extremes|InverseProblem|DirectProblem|StreamTraining|RankTraining|Planner)[.]|EveryShape|CondensationCache.AnyFlippedByte|/100000$")

foreach(program fem layer nn hw support figures scenes device networks contact sets live training studies commands)
  set(labels device)
  if(program MATCHES "^(fem|layer|nn)$")
    set(labels unit reference)
  elseif(program MATCHES "^(support|figures|scenes)$")
    set(labels unit)
  elseif(program STREQUAL "hw")
    set(labels unit hw)
  endif()
  foreach(test IN LISTS tactel_${program}_tests_TESTS)
    if(test MATCHES "${slow}")
      set_tests_properties("${test}" PROPERTIES LABELS "${labels};slow")
    else()
      set_tests_properties("${test}" PROPERTIES LABELS "${labels}")
    endif()
  endforeach()
endforeach()
