# Garbage for a server: datagrams of every sort that is none of its own, RATE a second, to every port from FIRST to LAST
# of HOST; and nonsense to its control port. Until SIGTERM.   perl flood.pl HOST CONTROL FIRST LAST RATE
use strict;
use warnings;
use Socket;
use Time::HiRes qw(sleep time);

my ($host, $control, $first, $last, $rate) = @ARGV;
my $ended = 0;
$SIG{TERM} = sub { $ended = 1 };
$SIG{PIPE} = 'IGNORE';
srand(1);
my $address = inet_aton($host) or die "no host $host\n";
socket(my $udp, PF_INET, SOCK_DGRAM, 0) or die $!;
sub noise { pack('C*', map { int(rand(256)) } 1 .. $_[0]) }

# What a stranger can know: the protocol's text. The header is magic, version, kind, reserved, session, packet number.
my $header = sub { pack('a4CCvQ<Q<', 'FELT', @_) };
my @garbage = (
  map({ noise($_) } 0, 1, 23, 24, 25, 128, 200, 1200, 1400),
  map({ $header->(1, $_, 0, int(rand(2**48)) << 8, 1 + int(rand(2**30))) . noise(120) } 0 .. 3, 255),
  $header->(2, 1, 0, 256, 1) . noise(120),
  $header->(1, 1, 7, 256, 1) . noise(120),
);
my ($sent, $begin, $next_call) = (0, time, time);
until ($ended) {
  for (1 .. 64) {
    my $port = $first + $sent % ($last - $first + 1);
    send($udp, $garbage[rand @garbage], 0, pack_sockaddr_in($port, $address));
    ++$sent;
  }
  if (time > $next_call) {  # ten times a second to the control port
    $next_call += 0.1;
    if (socket(my $tcp, PF_INET, SOCK_STREAM, 0) && connect($tcp, pack_sockaddr_in($control, $address))) {
      syswrite($tcp, noise(1 + int(rand(600))));
      close $tcp;
    }
  }
  my $ahead = $sent / $rate - (time - $begin);
  sleep($ahead) if $ahead > 0;
}
printf "sent %d datagrams in %.1f s\n", $sent, time - $begin;
