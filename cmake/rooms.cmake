# The floor plan: which room (folder) may include from which, and which foreign headers it may name. Arrows point down
# only: a room sees what is listed above it and named here, nothing else. cmake/floors.cmake checks every include against
# this table in each build; tests/floors_test.cpp plants faults that it must find. docs/architecture.md gives the picture.
#
#   room(FOLDER [SEES rooms…] [FOREIGN prefixes of headers…])
#
# `glm/` and the standard library are free to all. A room sees itself; `tests` sees everything.

room(shaders/shared FOREIGN immintrin.h)
room(shaders SEES shaders/shared)
foreach(kernels ao bench display film guided many_lights path reuse)
    room(shaders/${kernels} SEES shaders shaders/shared)
endforeach()

set(base core/base shaders/shared)
room(core/base FOREIGN pmmintrin.h tbb/ xmmintrin.h)
room(core/image SEES ${base} FOREIGN Imf jpeglib.h png.h)
room(core/scene SEES ${base} core/image)
room(core/gltf SEES ${base} core/image core/scene FOREIGN draco/ meshoptimizer.h nlohmann/ rapidjson/)
room(core/trace SEES ${base} core/scene FOREIGN embree3/ embree4/)
room(core/reuse SEES ${base})
room(core/guiding SEES ${base} core/reuse)
room(core/completion SEES ${base} FOREIGN immintrin.h)
room(core/many_lights SEES ${base} core/scene core/trace core/completion)
room(core/methods SEES ${base} core/image core/scene core/trace core/guiding core/completion core/many_lights)

set(gpu_base ${base} core/image core/scene app/gpu/base)
room(app/gpu/base SEES ${base} FOREIGN vulkan/)
room(app/gpu/window SEES ${gpu_base} FOREIGN spirv/)
room(app/gpu SEES ${gpu_base} core/trace core/guiding core/completion core/many_lights core/methods FOREIGN spirv/)
room(app/gpu/methods SEES ${gpu_base} core/guiding core/methods app/gpu FOREIGN spirv/)

set(core ${base} core/image core/scene core/gltf core/methods)
room(app/base SEES ${base} core/methods FOREIGN nlohmann/)
room(app/methods SEES ${core} app/gpu/base app/gpu/methods)
room(app/report SEES ${base} core/image)
room(app/lab SEES ${base} core/reuse core/guiding app/base app/report FOREIGN nlohmann/)
room(app/version SEES core/base core/trace app/base app/gpu/base FOREIGN CLI/ draco/ GLFW/ imgui jconfig.h
     meshoptimizer.h nlohmann/ OpenEXR/ png.h rapidjson/ tbb/)
room(app/args SEES ${core} app/base app/lab app/methods app/version FOREIGN CLI/)
room(app/files SEES ${core} app/base app/methods app/args FOREIGN nlohmann/)
room(app/commands SEES ${core} app/base app/args app/files app/lab app/methods app/gpu/base FOREIGN nlohmann/)
room(app/camera SEES ${base} core/scene core/trace app/base app/files)
room(app/pictures SEES ${core} app/report app/methods app/args app/files)
room(app/session SEES ${core} core/trace app/base app/report app/args app/files app/camera app/pictures FOREIGN nlohmann/)
set(bench ${base} core/image core/scene core/methods app/base app/args app/files app/report app/bench)
room(app/bench SEES ${base} core/image core/scene core/trace app/base app/version app/args app/files app/report app/methods app/gpu/base
     FOREIGN nlohmann/)
room(app/bench/throughput SEES ${bench} core/trace app/methods app/gpu FOREIGN nlohmann/)
room(app/bench/window SEES ${bench} app/methods app/session)
room(app/bench/flythrough SEES ${bench} core/trace app/methods app/pictures app/session app/bench/window FOREIGN nlohmann/)
room(app/bench/guiding SEES ${bench} app/methods app/session app/bench/window FOREIGN nlohmann/)
room(app/bench/light SEES ${bench} FOREIGN nlohmann/)
room(app/bench/many_lights SEES ${bench} core/completion core/many_lights app/version FOREIGN nlohmann/)
room(app/view/imgui SEES core/base app/gpu/base FOREIGN GLFW/ imgui backends/)
room(app/view/ui SEES ${core} app/base app/report app/methods app/files app/camera app/pictures app/session app/gpu/base
     app/view/imgui FOREIGN imgui nlohmann/)
room(app/view SEES ${core} app/base app/args app/files app/commands app/session app/view/imgui app/view/ui app/gpu/base
     app/gpu/window FOREIGN GLFW/ imgui backends/ nlohmann/ vulkan/)
room(app SEES core/base app/base app/args app/bench/throughput app/bench/flythrough app/bench/guiding app/bench/light
     app/bench/many_lights app/commands app/view)

room(assets/generator SEES ${base} core/image FOREIGN nlohmann/)
room(assets SEES core/base assets/generator)
room(bench SEES ${base} core/gltf core/scene core/trace core/reuse core/completion core/many_lights FOREIGN benchmark/)
