// See exr_fixture.h. The only file of the tests that includes OpenEXR.
#include "tests/support/files/exr_fixture.h"

#include <cstdint>
#include <cstring>
#include <sstream>

#include <half.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStdIO.h>
#include <ImfTiledOutputFile.h>

namespace tests {

namespace {

Imf::PixelType typeOf(ExrType type)
{
    return type == ExrType::half ? Imf::HALF : type == ExrType::unsigned32 ? Imf::UINT : Imf::FLOAT;
}

/// The values of a plane as its type stores them.
std::vector<std::byte> stored(const ExrPlane& plane)
{
    std::vector<std::byte> bytes;
    const auto append = [&](auto value) {
        const auto* first = reinterpret_cast<const std::byte*>(&value);
        bytes.insert(bytes.end(), first, first + sizeof(value));
    };
    for (const float value : plane.values) {
        if (plane.type == ExrType::half)
            append(Imath::half(value));
        else if (plane.type == ExrType::unsigned32)
            append(static_cast<uint32_t>(value));
        else
            append(value);
    }
    return bytes;
}

Imf::Header headerOf(const ExrPicture& picture)
{
    const Imath::Box2i window(
        Imath::V2i(picture.left, picture.top),
        Imath::V2i(picture.left + picture.width - 1, picture.top + picture.height - 1));
    Imf::Header header(window, window);
    header.compression() = static_cast<Imf::Compression>(picture.compression);
    if (picture.bottomUp) header.lineOrder() = Imf::DECREASING_Y;
    for (const ExrPlane& plane : picture.planes)
        header.channels().insert(plane.name,
                                 Imf::Channel(typeOf(plane.type), plane.sampling, plane.sampling));
    if (picture.tileSide > 0)
        header.setTileDescription(Imf::TileDescription(
            static_cast<unsigned>(picture.tileSide), static_cast<unsigned>(picture.tileSide),
            picture.levels ? Imf::MIPMAP_LEVELS : Imf::ONE_LEVEL));
    return header;
}

Imf::FrameBuffer bufferOf(const ExrPicture& picture, std::vector<std::vector<std::byte>>& memory)
{
    Imf::FrameBuffer buffer;
    memory.reserve(picture.planes.size());
    for (const ExrPlane& plane : picture.planes) {
        memory.push_back(stored(plane));
        const size_t pixel = plane.type == ExrType::half ? 2 : 4;
        buffer.insert(plane.name,
                      Imf::Slice::Make(typeOf(plane.type), memory.back().data(),
                                       Imath::V2i(picture.left, picture.top), picture.width,
                                       picture.height, pixel,
                                       pixel * static_cast<size_t>(picture.width / plane.sampling),
                                       plane.sampling, plane.sampling));
    }
    return buffer;
}

std::vector<std::byte> bytesIn(const Imf::StdOSStream& stream)
{
    const std::string text = stream.str();
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
}

}  // namespace

std::vector<std::byte> makeExr(const ExrPicture& picture)
{
    std::vector<std::vector<std::byte>> memory;
    const Imf::FrameBuffer buffer = bufferOf(picture, memory);
    Imf::StdOSStream stream;
    if (picture.tileSide > 0) {
        Imf::TiledOutputFile file(stream, headerOf(picture));
        file.setFrameBuffer(buffer);
        for (int level = 0; level < file.numLevels(); ++level)  // the lower ones show its corner
            file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    } else {
        Imf::OutputFile file(stream, headerOf(picture));
        file.setFrameBuffer(buffer);
        file.writePixels(picture.height);
    }
    return bytesIn(stream);
}

std::vector<std::byte> makeExrOfTwoParts(const ExrPicture& picture)
{
    std::vector<std::vector<std::byte>> memory;
    const Imf::FrameBuffer buffer = bufferOf(picture, memory);
    Imf::StdOSStream stream;
    {
        std::vector<Imf::Header> headers(2, headerOf(picture));
        headers[0].setName("first");
        headers[1].setName("second");
        for (Imf::Header& header : headers) header.setType(Imf::SCANLINEIMAGE);
        Imf::MultiPartOutputFile file(stream, headers.data(), 2);
        for (int part = 0; part < 2; ++part) {
            Imf::OutputPart output(file, part);
            output.setFrameBuffer(buffer);
            output.writePixels(picture.height);
        }
    }
    return bytesIn(stream);
}

}  // namespace tests
