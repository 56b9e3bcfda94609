// The stage in 3D: bodies of spheres and cylinders between the joints, all drawn at once. Loaded when it is first shown.
import {
  CanvasTexture, Color, CylinderGeometry, DirectionalLight, EdgesGeometry, GridHelper, Group, HemisphereLight, InstancedMesh, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, PlaneGeometry, RingGeometry, Scene, SphereGeometry, Sprite, SpriteMaterial, WebGLRenderer, BoxGeometry,
} from "three";
import { HEAD_JOINT, PARENTS } from "./skeleton";

export interface Surroundings {
  width: number;
  depth: number;
  obstacles: { at: [number, number]; to: [number, number] | null; radius: number }[];
}

export interface Colours {
  back: string;
  floor: string;
  line: string;
  ink: string;
  accent: string;
}

const JOINTS = PARENTS.length;
const LIMBS = PARENTS.map((parent, joint) => [joint, parent] as const).filter(([, parent]) => parent >= 0);
/** Radius at each joint [m]. */
const RADII = PARENTS.map((_, joint) => (joint <= 3 ? 0.105 : joint === HEAD_JOINT ? 0.115 : joint === 4 ? 0.055 : joint < 14 ? 0.042 : [14, 18].includes(joint) ? 0.085 : [15, 19].includes(joint) ? 0.062 : 0.045));
const VIEWS: Record<string, [number, number, number]> = { front: [0, 0.14, 1.05], above: [0, 1.5, 1.15], side: [Math.PI / 2, 0.16, 1.15], free: [0.55, 0.42, 1.4] };
const WALL_M = 1.2;

/** One picture in 3D in an element. */
export class SolidPicture {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(40, 1, 0.1, 200);
  private readonly surroundings = new Group();
  private readonly material = new MeshLambertMaterial();
  private balls: InstancedMesh | null = null;
  private limbs: InstancedMesh | null = null;
  private rings: InstancedMesh | null = null;
  private count = 0;
  private yaw = 0.55;
  private pitch = 0.42;
  private far = 1.4;
  private size = 10;
  private asked = 0;

  /** Throws where the browser has no WebGL. */
  constructor(element: HTMLElement, private colours: Colours) {
    this.renderer = new WebGLRenderer({ antialias: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    element.append(this.renderer.domElement);
    const sun = new DirectionalLight(0xffffff, 1.6);
    sun.position.set(3, 8, 6);
    this.scene.add(new HemisphereLight(0xffffff, 0x555566, 1.6), sun, this.surroundings);
    this.recolour(colours);
  }

  recolour(colours: Colours): void {
    this.colours = colours;
    this.scene.background = new Color(colours.back);
    this.draw();
  }

  resize(width: number, height: number): void {
    this.renderer.setSize(width, height);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  surround({ width, depth, obstacles }: Surroundings): void {
    this.size = Math.max(width, depth * 1.4);
    const { surroundings, colours } = this;
    surroundings.traverse((one) => (one instanceof Mesh || one instanceof LineSegments ? one.geometry.dispose() : undefined));
    surroundings.clear();
    const floor = new Mesh(new PlaneGeometry(width, depth), new MeshBasicMaterial({ color: colours.floor }));
    floor.rotation.x = -Math.PI / 2;
    floor.position.y = -0.01;
    const edge = new LineSegments(new EdgesGeometry(new PlaneGeometry(width, depth)), new LineBasicMaterial({ color: colours.line }));
    edge.rotation.x = -Math.PI / 2;
    const grid = new GridHelper(1, 1, colours.line, colours.line);
    const across = Math.round(width);
    const deep = Math.round(depth);
    grid.geometry.dispose();
    grid.geometry = new GridHelper(1, Math.max(across, deep, 1), colours.line, colours.line).geometry;
    grid.scale.set(width, 1, depth);
    (grid.material as LineBasicMaterial).opacity = 0.4;
    (grid.material as LineBasicMaterial).transparent = true;
    const front = new Mesh(new PlaneGeometry(width, 0.08), new MeshBasicMaterial({ color: colours.accent }));
    front.rotation.x = -Math.PI / 2;
    front.position.set(0, 0, depth / 2 + 0.08);
    surroundings.add(floor, edge, grid, front, this.words("public", 0, depth / 2 + 0.6));
    for (const { at, to, radius } of obstacles) {
      const material = new MeshLambertMaterial({ color: colours.line });
      if (to) {
        const long = Math.hypot(to[0] - at[0], to[1] - at[1]);
        const wall = new Mesh(new BoxGeometry(long, WALL_M, 0.08), material);
        wall.position.set((at[0] + to[0]) / 2, WALL_M / 2, (at[1] + to[1]) / 2);
        wall.rotation.y = -Math.atan2(to[1] - at[1], to[0] - at[0]);
        surroundings.add(wall);
      } else {
        const post = new Mesh(new CylinderGeometry(radius, radius, WALL_M, 20), material);
        post.position.set(at[0], WALL_M / 2, at[1]);
        surroundings.add(post);
      }
    }
    this.draw();
  }

  private words(text: string, x: number, z: number): Sprite {
    const canvas = document.createElement("canvas");
    canvas.width = 256;
    canvas.height = 64;
    const context = canvas.getContext("2d");
    if (context) {
      context.font = "44px system-ui, sans-serif";
      context.textAlign = "center";
      context.fillStyle = this.colours.ink;
      context.fillText(text, 128, 46);
    }
    const sprite = new Sprite(new SpriteMaterial({ map: new CanvasTexture(canvas) }));
    sprite.scale.set(1.6, 0.4, 1);
    sprite.position.set(x, 0.1, z);
    return sprite;
  }

  /** Joints (count x 22 x 3) [m]; the colour of each dancer, r, g, b from 0 to 1; who is there, and who is chosen (from 1). */
  pose(joints: Float32Array, colours: Float32Array, present: Uint8Array | null, chosen: ReadonlySet<number>): void {
    const count = Math.floor(joints.length / (3 * JOINTS));
    if (count !== this.count) this.hold(count);
    const { balls, limbs, rings } = this;
    if (!balls || !limbs || !rings) return;
    const ball = balls.instanceMatrix.array;
    const limb = limbs.instanceMatrix.array;
    const ring = rings.instanceMatrix.array;
    for (let dancer = 0; dancer < count; dancer++) {
      const there = !present || present[dancer] ? 1 : 0;
      const base = dancer * JOINTS * 3;
      for (let joint = 0; joint < JOINTS; joint++) {
        const at = base + 3 * joint;
        const radius = there * (RADII[joint] as number);
        const to = 16 * (dancer * JOINTS + joint);
        ball[to] = radius;
        ball[to + 5] = joint === HEAD_JOINT ? 1.25 * radius : radius;
        ball[to + 10] = radius;
        ball[to + 15] = 1;
        ball[to + 12] = joints[at] as number;
        ball[to + 13] = (joints[at + 1] as number) + (joint === HEAD_JOINT ? 0.09 : 0);
        ball[to + 14] = joints[at + 2] as number;
      }
      for (let index = 0; index < LIMBS.length; index++) {
        const [joint, parent] = LIMBS[index] as readonly [number, number];
        span(limb, 16 * (dancer * LIMBS.length + index), joints, base + 3 * parent, base + 3 * joint, there * Math.min(RADII[joint] as number, RADII[parent] as number));
      }
      const to = 16 * dancer;
      const size = there && chosen.has(dancer + 1) ? 1 : 0;
      ring[to] = ring[to + 5] = ring[to + 10] = size;
      ring[to + 15] = 1;
      ring[to + 12] = joints[base] as number;
      ring[to + 13] = 0.01;
      ring[to + 14] = joints[base + 2] as number;
    }
    balls.instanceMatrix.needsUpdate = limbs.instanceMatrix.needsUpdate = rings.instanceMatrix.needsUpdate = true;
    this.paintBodies(colours);
    this.draw();
  }

  private painted: Float32Array | null = null;

  private paintBodies(colours: Float32Array): void {
    const { balls, limbs } = this;
    if (!balls || !limbs || this.painted === colours) return;
    this.painted = colours;
    const colour = new Color();
    for (let dancer = 0; dancer < this.count; dancer++) {
      colour.setRGB(colours[3 * dancer] ?? 0.6, colours[3 * dancer + 1] ?? 0.6, colours[3 * dancer + 2] ?? 0.6);
      for (let joint = 0; joint < JOINTS; joint++) balls.setColorAt(dancer * JOINTS + joint, colour);
      for (let index = 0; index < LIMBS.length; index++) limbs.setColorAt(dancer * LIMBS.length + index, colour);
    }
    if (balls.instanceColor) balls.instanceColor.needsUpdate = true;
    if (limbs.instanceColor) limbs.instanceColor.needsUpdate = true;
  }

  private hold(count: number): void {
    for (const one of [this.balls, this.limbs, this.rings]) {
      if (!one) continue;
      this.scene.remove(one);
      one.geometry.dispose();
      one.dispose();
    }
    this.count = count;
    this.painted = null;
    this.balls = new InstancedMesh(new SphereGeometry(1, 10, 8), this.material, Math.max(count * JOINTS, 1));
    this.limbs = new InstancedMesh(new CylinderGeometry(1, 1, 1, 8, 1, true), this.material, Math.max(count * LIMBS.length, 1));
    const flat = new RingGeometry(0.32, 0.38, 28).rotateX(-Math.PI / 2);
    this.rings = new InstancedMesh(flat, new MeshBasicMaterial({ color: this.colours.accent }), Math.max(count, 1));
    for (const one of [this.balls, this.limbs, this.rings]) {
      one.frustumCulled = false;
      this.scene.add(one);
    }
  }

  /** From the front, from above, from a side, or from aside. */
  look(from: string): void {
    [this.yaw, this.pitch, this.far] = VIEWS[from] ?? [this.yaw, this.pitch, this.far];
    this.draw();
  }

  orbit(right: number, up: number, nearer = 1): void {
    this.yaw += right;
    this.pitch = Math.min(1.55, Math.max(0.02, this.pitch + up));
    this.far = Math.min(4, Math.max(0.25, this.far * nearer));
    this.draw();
  }

  private draw(): void {
    cancelAnimationFrame(this.asked);
    this.asked = requestAnimationFrame(() => {
      const away = this.far * this.size * (this.camera.aspect < 1.2 ? 1.2 / this.camera.aspect : 1);
      const flat = Math.cos(this.pitch) * away;
      this.camera.position.set(Math.sin(this.yaw) * flat, 0.9 + Math.sin(this.pitch) * away, Math.cos(this.yaw) * flat);
      this.camera.lookAt(0, 0.7, 0);
      this.renderer.render(this.scene, this.camera);
    });
  }

  dispose(): void {
    cancelAnimationFrame(this.asked);
    this.hold(0);
    this.renderer.dispose();
    this.renderer.domElement.remove();
  }
}

/** The matrix of a cylinder of height 1 along y that spans from one joint to another. */
function span(into: { [index: number]: number }, to: number, joints: Float32Array, a: number, b: number, radius: number): void {
  const [ax, ay, az] = [joints[a] as number, joints[a + 1] as number, joints[a + 2] as number];
  const [dx, dy, dz] = [(joints[b] as number) - ax, (joints[b + 1] as number) - ay, (joints[b + 2] as number) - az];
  const long = Math.hypot(dx, dy, dz) || 1e-6;
  const [ux, uy, uz] = [dx / long, dy / long, dz / long];
  // any unit vector across: the axis that is least along it, made perpendicular
  let [px, py, pz] = Math.abs(ux) < 0.8 ? [1 - ux * ux, -ux * uy, -ux * uz] : [-uy * ux, 1 - uy * uy, -uy * uz];
  const scale = radius / (Math.hypot(px, py, pz) || 1);
  [px, py, pz] = [px * scale, py * scale, pz * scale];
  into[to] = px;
  into[to + 1] = py;
  into[to + 2] = pz;
  into[to + 4] = dx;
  into[to + 5] = dy;
  into[to + 6] = dz;
  into[to + 8] = py * uz - pz * uy;
  into[to + 9] = pz * ux - px * uz;
  into[to + 10] = px * uy - py * ux;
  into[to + 12] = ax + dx / 2;
  into[to + 13] = ay + dy / 2;
  into[to + 14] = az + dz / 2;
  into[to + 15] = 1;
}
