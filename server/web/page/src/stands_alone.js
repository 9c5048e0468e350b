/** Whether the page shows recordings only, and connects to nothing. */
export const standsAlone = () => location.protocol === 'file:' || location.pathname.endsWith('/replay');
