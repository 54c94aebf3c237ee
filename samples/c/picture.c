#include "picture.h"

#include "host.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static FILE *open_file(const char *prefix, const char *extension) {
    char path[4096];
    const int length = snprintf(path, sizeof path, "%s%s", prefix, extension);
    FILE *file = length < 0 || (size_t)length >= sizeof path ? NULL : fopen(path, "wb");
    if (file == NULL) fail("the output file cannot be opened");
    return file;
}

static void close_file(FILE *file) {
    const int failed = ferror(file);
    if (fclose(file) != 0 || failed) fail("the output file cannot be written");
}

void write_pfm(const char *prefix, const float *rgba, uint32_t width, uint32_t height) {
    const uint32_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    FILE *file = open_file(prefix, ".pfm");
    /* The sign of the last number tells the order of bytes; rows go from the bottom. */
    fprintf(file, "PF\n%u %u\n%s\n", (unsigned)width, (unsigned)height, first == 1 ? "-1.0" : "1.0");
    for (uint32_t y = height; y-- > 0;)
        for (uint32_t x = 0; x < width; x++) fwrite(rgba + ((size_t)y * width + x) * 4, sizeof(float), 3, file);
    close_file(file);
}

void write_ppm(const char *prefix, const float *rgba, uint32_t width, uint32_t height) {
    FILE *file = open_file(prefix, ".ppm");
    fprintf(file, "P6\n%u %u\n255\n", (unsigned)width, (unsigned)height);
    for (size_t i = 0; i < (size_t)width * height; i++) {
        for (size_t c = 0; c < 3; c++) {
            const float mapped = rgba[i * 4 + c] / (rgba[i * 4 + c] + 0.5f);
            const float encoded = mapped <= 0.0031308f ? 12.92f * mapped : 1.055f * powf(mapped, 1.0f / 2.4f) - 0.055f;
            fputc((int)(255.0f * fminf(fmaxf(encoded, 0.0f), 1.0f) + 0.5f), file);
        }
    }
    close_file(file);
}
