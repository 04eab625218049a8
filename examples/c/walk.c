/* A person walks into a kick: reads a compiled world and poses, steps, prints where the person and the objects are.
 *
 *     python examples/c/write_world.py kick.hpw kick.poses        # once, in Python
 *     cmake -S . -B build/c -DHALFPHYSICS_PYTHON=OFF -DHALFPHYSICS_C=ON && cmake --build build/c
 *     cc -std=c99 -Wall -Wextra -Werror -Isrc/native/capi examples/c/walk.c -Lbuild/c -lhalfphysics -o walk
 *     LD_LIBRARY_PATH=build/c ./walk kick.hpw kick.poses 300
 *
 * The file of poses has doubles only: frames per second, then frame after frame translation (3) and rotations (55 x 3). */
#include <stdio.h>
#include <stdlib.h>

#include "halfphysics.h"

enum { POSE = 3 + 3 * HP_JOINTS };

static int fail(const char *what) {
  fprintf(stderr, "%s: %s\n", what, hp_error());
  return 1;
}

/* The next pose; from the first again where the file ends. */
static int next_pose(FILE *file, double *pose) {
  if (fread(pose, sizeof *pose, POSE, file) == POSE) return 1;
  return fseek(file, sizeof *pose, SEEK_SET) == 0 && fread(pose, sizeof *pose, POSE, file) == POSE;
}

static int run(hp_world *world, FILE *file, int frames) {
  double fps, pose[POSE], position[3], quaternion[4];
  hp_contact contact;
  size_t contacts = 0;
  if (fread(&fps, sizeof fps, 1, file) != 1 || !next_pose(file, pose)) return fail("poses");
  if (hp_reset(world, pose, pose + 3) != HP_OK) return fail("reset");
  for (int i = 1; i <= frames; i++) {
    if (!next_pose(file, pose)) return fail("poses");
    if (hp_step(world, pose, pose + 3, 1 / fps) != HP_OK) return fail("step");
    if (hp_get_contacts(world, &contact, 1, &contacts) != HP_OK) return fail("contacts");
    if (contacts > 0 && hp_kind_of(world, contact.other) == HP_OBJECT)
      printf("frame %d: %s, %.2f N s\n", i, hp_name(world, contact.other), contact.impulse[0]);
  }
  if (hp_get_pose(world, 0, pose, pose + 3) != HP_OK) return fail("pose");
  for (int i = 0; i < POSE; i++) printf("%a%c", pose[i], i + 1 < POSE ? ' ' : '\n');
  for (int i = 0; i < hp_name_count(world); i++) {
    if (hp_kind_of(world, i) != HP_OBJECT) continue;
    if (hp_get_object(world, hp_name(world, i), position, quaternion)) return fail("object");
    printf("%s %a %a %a\n", hp_name(world, i), position[0], position[1], position[2]);
  }
  return 0;
}

int main(int argc, char **argv) {
  if (argc != 4) return fprintf(stderr, "usage: %s WORLD POSES FRAMES\n", argv[0]), 2;
  hp_world *world = hp_world_open(argv[1]);
  if (!world) return fail(argv[1]);
  FILE *file = fopen(argv[2], "rb");
  const int status = file ? run(world, file, atoi(argv[3])) : fail(argv[2]);
  if (file) fclose(file);
  hp_world_free(world);
  return status;
}
