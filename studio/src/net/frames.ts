// Binary frames of the stage: u8 kind, u8 flags, u16 count, u32 tick, then int16, all little-endian (`live docs web`).

export const POSITIONS = 1;
export const JOINTS = 2;
export const WAVEFORM = 3;
export const PICTURE = 4;
export const DOCUMENT = 5;
export const JOINT_COUNT = 22;
const HEAD = 8;
const METRES = 1e-3;
const TURN = (2 * Math.PI) / 10_000;

export interface Positions {
  tick: number;
  count: number;
  /** x, z [m] and heading [rad] of each dancer. */
  rows: Float32Array;
  /** Who is on the stage: the number of their group, from 1; 0: not there. */
  present: Uint8Array;
}

export interface Joints {
  tick: number;
  count: number;
  /** Whether only the chosen dancers are in it. */
  chosen: boolean;
  /** x, y, z [m] of each joint. */
  rows: Float32Array;
}

export function frameKind(data: DataView): number {
  return data.byteLength >= HEAD ? data.getUint8(0) : 0;
}

export function readPositions(data: DataView, into?: Positions): Positions {
  const count = Math.min(data.getUint16(2, true), Math.floor((data.byteLength - HEAD) / 8));
  const found = into?.count === count ? into : { tick: 0, count, rows: new Float32Array(3 * count), present: new Uint8Array(count) };
  found.tick = data.getUint32(4, true);
  for (let row = 0, at = HEAD; row < count; row++, at += 8) {
    found.rows[3 * row] = data.getInt16(at, true) * METRES;
    found.rows[3 * row + 1] = data.getInt16(at + 2, true) * METRES;
    found.rows[3 * row + 2] = data.getInt16(at + 4, true) * TURN;
    found.present[row] = Math.min(255, Math.max(0, data.getInt16(at + 6, true)));
  }
  return found;
}

export function readJoints(data: DataView): Joints {
  const size = 3 * JOINT_COUNT;
  const count = Math.min(data.getUint16(2, true), Math.floor((data.byteLength - HEAD) / (2 * size)));
  const rows = new Float32Array(count * size);
  const at = data.byteOffset + HEAD;
  const values = at % 2 ? null : new Int16Array(data.buffer, at, rows.length); // every browser's machine is little-endian
  for (let index = 0; index < rows.length; index++) rows[index] = (values ? (values[index] as number) : data.getInt16(HEAD + 2 * index, true)) * METRES;
  return { tick: data.getUint32(4, true), count, chosen: data.getUint8(1) === 1, rows };
}

/** How loud the music is over its time: peaks of full scale 255, so many a second. */
export interface Waveform {
  rate: number;
  peaks: Uint8Array;
}

export function readWaveform(data: DataView): Waveform {
  const count = Math.min(data.getUint32(4, true), data.byteLength - HEAD);
  return { rate: Math.max(data.getUint16(2, true), 1), peaks: new Uint8Array(data.buffer, data.byteOffset + HEAD, count) };
}

/** The picture as it is projected. */
export interface ProjectedPicture {
  width: number;
  height: number;
  jpeg: Blob;
}

export function readPicture(data: DataView): ProjectedPicture {
  const jpeg = new Blob([new Uint8Array(data.buffer, data.byteOffset + HEAD, data.byteLength - HEAD).slice()], { type: "image/jpeg" });
  return { width: data.getUint16(2, true), height: data.getUint16(4, true), jpeg };
}

/** A PDF. */
export function readDocument(data: DataView): Blob {
  const length = Math.min(data.getUint32(4, true), data.byteLength - HEAD);
  return new Blob([new Uint8Array(data.buffer, data.byteOffset + HEAD, length).slice()], { type: "application/pdf" });
}
