# SPDX-License-Identifier: Apache-2.0

cmake_policy(VERSION 3.25)

# Read by ctest after the lists of tests that the programs gave: the labels of each.
#   unit       needs no OpenCL device      device  needs one (PoCL is enough)
#   program    runs the program `tactel`   slow    takes more than five seconds of a processor
#   reference  mechanics and networks      hw      sensors
#   usb_guest  a kernel in a virtual machine
#   nightly    run by scripts/nightly alone

# A suite is of one kind. Its name, or the prefix of its INSTANTIATE, ends in Nightly, Slow or OnDevice, or a list below has it.
# What is nightly has another test of its kind in scripts/test: it takes more numbers of lanes, elements and layers, more moments of a kill,
# larger campaigns, a second runtime, a second precision.

# Suites that need no device, by test program; all of these programs. CTest runs them without OpenCL platforms, where one that needs a
# device fails.
set(unit_programs fem layer pad nn hw support figures scenes)
set(unit_device Balance Cache CachePlace Embedded GroupSupply KernelParameters LayoutList LeftFolder Pace ThreadTeam ThreadTeamDeathTest)
set(unit_networks OnnxFile)
set(unit_answers Extrapolation Ladder PadConvergence PadJudge PadJudgeOf PadStrain Planner Quantities RungError SolveOptions)
set(unit_sets CheckSet CheckSetBytes MeasuringChains PaperShapes TransducerTable)
set(unit_live Alarm Calibration CsvFile CsvPipe CsvTerminal FrameQueue LatencyHistogram Left LiveView OpenSource SensorProfile)
set(unit_training AlarmCounting BoundReport TrainingSources)
set(unit_api AlarmApi CraftedNetworks CraftedNetworksSlow Infer InferHost LiveApi LiveApiProfile PadSceneApi SceneApi)
set(unit_studies HandPress InverseReport LoopDrift RealSensorPlan SceneMix TradeoffReport)
set(unit_commands BadSceneTest CommandLine Completion DevicesCommandDeathTest GenerateOutputs Help HostileFiles Keys LiveServer Memory MonitorOptions
    Numbers ProfileFile ReadmeFiles SolveOnHost StandardError UnreadableScene Words WrongCallTest)

# Suites that run the program; in commands, those that do not.
set(program_networks OnnxRuntime)
set(program_sets CheckSet ContactSetInH5py)
set(program_training FrameFloor RankTraining Stream StreamTraining TrainResume)
set(program_studies InverseCommand)
set(no_program DevicesCommand DevicesCommandDeathTest LiveServer)

# Suites that are slow as a whole.
set(slow ClosedForms DirectProblem EveryShape EveryShapeOnMeshA Extremes GapReferenceRandom IndependentContact InverseCommand InverseProblem
    OverTheEnd PadConvergence PadReference RankTraining SaidAndMade StreamTraining)

foreach(program fem layer pad nn hw support figures scenes device networks contact answers sets live training studies commands api)
  foreach(test IN LISTS tactel_${program}_tests_TESTS)
    string(REGEX REPLACE "[.<].*" "/" name "${test}")  # PREFIX/SUITE/
    string(REGEX REPLACE "^.*/(.+)/$" "\\1" suite "/${name}")
    set(labels device)
    if((program IN_LIST unit_programs OR suite IN_LIST unit_${program}) AND NOT name MATCHES "OnDevice/")
      set(labels unit)
      set_tests_properties("${test}" PROPERTIES ENVIRONMENT_MODIFICATION OCL_ICD_VENDORS=set:/no/device)
    endif()
    if(suite IN_LIST program_${program} OR program STREQUAL "commands" AND NOT suite IN_LIST no_program)
      list(APPEND labels program)
    endif()
    if(program MATCHES "^(fem|layer|pad|nn)$")
      list(APPEND labels reference)
    elseif(program STREQUAL "hw")
      list(APPEND labels hw)
    endif()
    if(name MATCHES "Slow/" OR suite IN_LIST slow)
      list(APPEND labels slow)
      set_tests_properties("${test}" PROPERTIES COST 10)  # begins before the short ones, so that no processor waits for it at the end
    endif()
    if(name MATCHES "Nightly/")
      set(labels nightly)
    endif()
    set_tests_properties("${test}" PROPERTIES LABELS "${labels}")
  endforeach()
endforeach()
