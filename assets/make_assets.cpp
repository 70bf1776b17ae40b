// Writes the scenes of this folder: make_assets DIR. The same program gives the same bytes.
#include <cstdio>

#include "assets/generator/scenes.h"
#include "core/base/check.h"

int main(int argc, char** argv)
{
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_assets DIR\n");
        return int(core::ExitCode::commandLine);
    }
    try {
        assets::writeAll(argv[1]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "make_assets: %s\n", error.what());
        return int(core::ExitCode::failure);
    }
    return int(core::ExitCode::done);
}
