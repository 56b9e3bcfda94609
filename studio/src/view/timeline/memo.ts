import { Component, h, type ComponentChildren, type FunctionComponent } from "preact";

/** A component that is drawn anew only if one of its properties, or a signal that it reads, has changed. */
export function memo<P extends object>(draw: FunctionComponent<P>): FunctionComponent<P> {
  class Kept extends Component<P> {
    override shouldComponentUpdate(next: P): boolean {
      const before = this.props as Record<string, unknown>;
      const after = next as Record<string, unknown>;
      const keys = Object.keys(after);
      return keys.length !== Object.keys(before).length || keys.some((key) => before[key] !== after[key]);
    }

    override render(): ComponentChildren {
      return h(draw as FunctionComponent, this.props as never);
    }
  }
  return Kept as unknown as FunctionComponent<P>;
}
