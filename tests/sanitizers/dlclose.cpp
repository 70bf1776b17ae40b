// Part of sanitizer builds of the tests and of the program: a library once loaded stays. Reports
// are symbolised, and lost memory is looked for, when the process ends. By then the Vulkan loader
// has unloaded the drivers and layers: their frames have no name, no suppression fits them, and
// what their variables still point to counts as lost.
#include "tests/support/process/sanitized.h"

#ifdef REKINDLE_SANITIZED
extern "C" int dlclose(void* library);
extern "C" int dlclose(void*)
{
    return 0;
}
#endif
