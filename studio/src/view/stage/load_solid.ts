// The part of the page that draws in 3D, loaded when it is first needed.
export const loadSolid = () => import("./stage3d.js");
