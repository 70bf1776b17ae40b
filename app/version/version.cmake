# Writes OUTPUT with the version and the commit being built, and how; touches it only when they change. Run at every build.
execute_process(COMMAND git rev-parse --short HEAD WORKING_DIRECTORY ${SOURCE}
    OUTPUT_VARIABLE COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
execute_process(COMMAND git status --porcelain --untracked-files=no WORKING_DIRECTORY ${SOURCE}
    OUTPUT_VARIABLE CHANGES ERROR_QUIET)
if(COMMIT AND CHANGES)
    string(APPEND COMMIT "+")  # with changes that are in no commit
endif()
set(IS_NATIVE 0)
if(NATIVE)
    set(IS_NATIVE 1)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT
"#pragma once
#define REKINDLE_VERSION \"${VERSION}\"
#define REKINDLE_COMMIT \"${COMMIT}\"
#define REKINDLE_BUILD_TYPE \"${TYPE}\"
#define REKINDLE_NATIVE ${IS_NATIVE}
#define REKINDLE_SANITIZE \"${SANITIZE}\"
")
