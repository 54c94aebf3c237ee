/* Pictures as files. Pixels are RGBA floats, rows from the top; a failure ends the program. */
#ifndef PICTURE_H
#define PICTURE_H

#include <stdint.h>

/* PREFIX.pfm: the numbers as they are. */
void write_pfm(const char *prefix, const float *rgba, uint32_t width, uint32_t height);
/* PREFIX.ppm: tone-mapped, sRGB, to look at. */
void write_ppm(const char *prefix, const float *rgba, uint32_t width, uint32_t height);

#endif
