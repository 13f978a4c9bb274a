// Numbers as one says them.
export const meters = (value: number, digits = 1): string => `${value.toFixed(digits)} m`;

export function seconds(value: number): string {
  if (value < 100) return `${value.toFixed(1)} s`;
  return `${Math.floor(value / 60)}:${String(Math.round(value % 60)).padStart(2, "0")} min`;
}

export const share = (value: number): string => `${+(100 * value).toFixed(1)} %`;
