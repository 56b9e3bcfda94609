// The joints of the engine's skeleton, as its frames have them (live/motion/skeleton.py; a test compares the two).

/** Parent of each joint; -1: none. */
export const PARENTS = [-1, 0, 1, 2, 3, 4, 3, 6, 7, 8, 3, 10, 11, 12, 0, 14, 15, 16, 0, 18, 19, 20];
/** Where each joint is in the rest pose, facing the public [mm]: x, y, z one after the other. */
export const REST_MM = [
  0, 935, 0,
  0, 1030, 0,
  0, 1150, -5,
  0, 1275, -10,
  0, 1425, -10,
  0, 1515, 0,
  30, 1380, -5,
  165, 1380, -10,
  430, 1380, -10,
  675, 1380, -10,
  -30, 1380, -5,
  -165, 1380, -10,
  -430, 1380, -10,
  -675, 1380, -10,
  90, 890, 0,
  90, 475, 0,
  90, 85, 0,
  90, 20, 130,
  -90, 890, 0,
  -90, 475, 0,
  -90, 85, 0,
  -90, 20, 130,
];
export const HEAD_JOINT = 5;
