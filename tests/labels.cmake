# SPDX-License-Identifier: Apache-2.0

# Read by ctest after the lists of tests that the programs gave: the labels of each.
#   unit       needs no OpenCL device      device  needs one (PoCL is enough)
#   program    runs the program `tactel`   slow    takes more than five seconds of a processor
#   reference  mechanics and networks      hw      sensors
#   usb_guest  a kernel in a virtual machine
#   nightly    run by scripts/nightly alone

# Regular expressions of test names, by test program. A unit test runs without OpenCL platforms (below): it fails where it needs one.
foreach(program fem layer pad nn hw support figures scenes)
  set(unit_${program} ".")
endforeach()
set(unit_device "^(ThreadTeam|Cache|CachePlace|GroupSupply|Pace|LayoutList)[.]|/(LeftFolder|Balance)[.]|^Embedded[.][EI]|OfADoubleProgram|GoesOnWithTheThreads")
set(unit_networks "^(OnnxChain[.]|OnnxFile[.][^MK])")
set(unit_contact "^(Ladder|RungError|Extrapolation|PadConvergence|PadJudge)[.]|PadJudgeOf[.]|^Planner[.][^K]|AccuracyAndTolerance")
set(unit_sets "^(CheckSet|MeasuringChains)[.]|ThirtyTwoTaylor|^TransducerTable[.][GP]")
set(unit_calibration ".")
set(unit_live "^(FrameQueue|LatencyHistogram|SensorProfile|Calibration|OpenSource|LiveView|Alarm|Csv[A-Za-z]+)[.]")
set(unit_training "StreamAndBlockExclude|^(AlarmCounting|BoundReport)[.]")
set(unit_api "^(CraftedNetworks[.]|Infer[.][^G]|InferHost[.]|Infer[.]GivesTheS|LiveApi[.]|SceneApi[.]|PadSceneApi[.])")
set(unit_studies "^(HandPress|LoopDrift|SceneMix|TradeoffReport)[.]|^InverseProblem[.](Spread|Json|Counts)|AllCombinations|SlipIndexIs|DrawsAre|TheAngleAlone")
set(unit_commands "^(DevicesCommandDeathTest|UnreadableScene|StandardError|Help|Completion|Words|Numbers|Memory|HostileFiles|ProfileFile|Keys)[.]|BadScene|WrongCall|^CommandLine[.][HS]|OutputsThatCannotBe|TimesThatAreNone|FilesItNames|^SolveCommand[.](SlipIndex|JsonNumbers|Missed)")
# Of these, the calls that a device must judge.
set(device_commands "WrongCall.*/(UnknownDevice|Step)|APipeWithoutAWriter")

set(program_networks "^OnnxRuntime")
set(program_sets "OpensInH5py|NamesTheRowsOfADamagedChunk|FindsEveryEdit")
set(program_training "^[^AB]")
set(program_studies "[.]Reproduce")
set(program_commands "^([^D]|Du|Dem)")  # all but DevicesCommand

set(slow "SaidAndMade|^CraftedNetworks[.]NoChange|^SolveWithCache[.](Nobody|Killed|Little|Two|Inter|Locks)|^(ClosedForms|GapReferenceRandom|IndependentContact|Extremes|InverseProblem|DirectProblem|StreamTraining|RankTraining)[.]|^Planner[.]K|OverTheEnd|^Demo[.]S|EveryShape|^(PadReference|PadCalibration|PadConvergence)[.]|CondensationCache.AnyFlippedByte|/100000$")

# What scripts/test leaves to scripts/nightly, because another test of its kind stays: more numbers of lanes, elements and layers, more moments of
# a kill, larger campaigns, a second runtime, a second precision.
set(nightly "Nightly[.]|^(Lanes[.]|PatchBits[.]AreTheSameAt|PatchBits.*Chunks<double>|NetworkLanes[.]T|NetworkLanes.*<double>)"
  "^(SolveWithCache[.](Inter|Little)|OnAFullDisk[.]ThatFillsD|InverseProblem[.](Goes|Leaves)|Durability[.]NetworksOfS|BadFiles[.]FileOfAFrame)"
  "Twin[.]Fp64MatchesIt/(16|24)$|/RandomPads.*_cells_100000|/Twin[.]Fp32MatchesIt/16$|MeshAMatchesReference/0(|[.]45|[.]49)$|MatchesReference/\"30-31-33-1\"|OfSeveralFrames"
  "^(Extremes[.]Every|Planner[.]Keeps|DirectProblem[.]EveryOpen|CalibrationCampaign|PressPlan[.]Ten|PatchSensors[.]AgreeWith|TrainApi[.]TrainsB|BoundCommand[.]MonitorP)")
list(JOIN nightly "|" nightly)

foreach(program fem layer pad nn hw support figures scenes device networks contact calibration sets live training studies commands api)
  foreach(test IN LISTS tactel_${program}_tests_TESTS)
    set(labels device)
    if(test MATCHES "${unit_${program}}")
      set(labels unit)
    endif()
    if(DEFINED device_${program})
      if(test MATCHES "${device_${program}}")
        set(labels device)
      endif()
    endif()
    if(labels STREQUAL "unit")
      set_tests_properties("${test}" PROPERTIES ENVIRONMENT_MODIFICATION OCL_ICD_VENDORS=set:/no/device)
    endif()
    if(DEFINED program_${program})
      if(test MATCHES "${program_${program}}")
        set(labels "${labels};program")
      endif()
    endif()
    if(program MATCHES "^(fem|layer|pad|nn)$")
      set(labels "${labels};reference")
    elseif(program STREQUAL "hw")
      set(labels "${labels};hw")
    endif()
    if(test MATCHES "${slow}")
      set(labels "${labels};slow")
    endif()
    if(test MATCHES "${nightly}")
      set(labels nightly)
    endif()
    set_tests_properties("${test}" PROPERTIES LABELS "${labels}")
  endforeach()
endforeach()
