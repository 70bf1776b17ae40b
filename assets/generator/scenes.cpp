// Everything at once.
#include "assets/generator/scenes.h"

#include "assets/generator/textures.h"

namespace assets {

void writeAll(const std::filesystem::path& folder)
{
    std::filesystem::create_directories(folder);
    writeTextures(folder / "textures");
    writeCornellBoxes(folder);
    writeFurnaces(folder);
    writeHall(folder);
    writeDoorAjar(folder);
    writeTextured(folder);
    writeGlass(folder);
    writeLights(folder);
    writeSky(folder);
    writeAnimated(folder);
}

}  // namespace assets
