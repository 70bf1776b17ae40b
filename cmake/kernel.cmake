# One kernel from GLSL to an array of words in a header: compiled, optimised, embedded. Run by the build.
#   cmake -DKERNEL=FILE -DNAME=NAME -DHEADER=FILE -DINCLUDE=DIR -DGLSLANG=PROGRAM -DSPIRV_OPT=PROGRAM
#         -DMACRO=-DMACRO -P cmake/kernel.cmake
# Drivers do the same work anew in every run: software drivers make pipelines of what is inlined, and free of most
# variables in memory, in .5 to .7 of the time. Left out, of what -O or -Os of spirv-opt would do:
# - simplify-instructions, which joins products of constants: the kernels' results would differ in their last bits from
#   each other's and from those of the C++ text;
# - merge-return, which makes conditions of early returns: megakernels ran up to a fifth slower so. Functions with early
#   returns are left for the driver to inline, with a warning for each, which is not shown;
# - ssa-rewrite, with which the kernels of sample reuse ran a tenth to a fifth slower.
set(PASSES --inline-entry-points-exhaustive --eliminate-dead-functions --private-to-local --scalar-replacement=0
    --eliminate-local-single-block --eliminate-local-single-store --eliminate-dead-code-aggressive)

get_filename_component(folder ${HEADER} DIRECTORY)
file(MAKE_DIRECTORY ${folder})

# Runs a program; what it says is shown when it fails.
function(run what)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
    if(NOT status EQUAL 0)
        message(FATAL_ERROR "${KERNEL} could not be ${what}:\n${said}")
    endif()
endfunction()
set(plain ${HEADER}.plain.spv)
set(optimised ${HEADER}.spv)
run(compiled ${GLSLANG} -V --quiet --target-env vulkan1.3 ${MACRO} -I${INCLUDE} --depfile ${HEADER}.d -o ${plain} ${KERNEL})
run(optimised ${SPIRV_OPT} --target-env=vulkan1.3 --scalar-block-layout --preserve-bindings
    ${PASSES} ${plain} -o ${optimised})

# It is the header that depends on what was read.
file(READ ${HEADER}.d dependencies)
string(REPLACE "${plain}:" "${HEADER}:" dependencies "${dependencies}")
file(WRITE ${HEADER}.d "${dependencies}")

file(READ ${optimised} words HEX)
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${words}")
string(REGEX REPLACE "(0x........,0x........,0x........,0x........,0x........,0x........,0x........,0x........,)" "\\1\n"
       words "${words}")
file(WRITE ${HEADER} "#pragma once\nconst uint32_t k_${NAME}[] = {\n${words}\n};\n")
