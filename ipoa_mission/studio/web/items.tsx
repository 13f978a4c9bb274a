// The items of the planned mission, as they are numbered on the vehicle: what each does, where, and when it is done.
import { chooseItem, proved, type Studio } from "./store";
import { seconds } from "./words";

export function Items({ now }: { now: Studio }) {
  const plan = proved(now);
  if (!plan) return null;
  return (
    <details class="panel items" open>
      <summary>Items</summary>
      <div class="scroll" tabIndex={0} role="region" aria-label="Items">
        <table>
          <thead><tr><th scope="col">item</th><th scope="col">above home</th><th scope="col">above ground</th><th scope="col">done at</th></tr></thead>
          <tbody>
            {plan.stops.map((stop, n) => (
              <tr key={n} class={stop.seq === now.item ? "chosen" : ""}>
                <th scope="row"><button type="button" aria-pressed={stop.seq === now.item} onClick={() => chooseItem(stop.seq)}>{stop.seq} {stop.words}</button></th>
                <td>{stop.up === null ? "" : `${stop.up.toFixed(1)} m`}</td><td>{stop.above_ground === null ? "" : `${stop.above_ground.toFixed(1)} m`}</td>
                <td>{seconds(stop.done_s)}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </details>
  );
}
